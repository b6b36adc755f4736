import math

import pytest

from ppaas.controllers.dwa import DwaParameters
from ppaas.errors import InvalidParameter
from ppaas.parameters import read_parameters


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("max_vel_x", 0.0),
        ("max_vel_x", math.nan),
        ("acc_lim_x", -1.0),
        ("sim_time", math.inf),
        ("sim_time", "long"),
        ("sim_granularity", 0),
        ("vx_samples", 0),
        ("vth_samples", 2.5),
        ("xy_goal_tolerance", -0.1),
        ("max_vel_theta", True),
        ("allow_unknown", 1),
        ("min_vel_x", 0.6),
        ("min_vel_theta", 2.0),
        ("cost_slowdown", 1.0),
    ],
)
def test_invalid_parameters_are_refused_by_name(name, value):
    with pytest.raises(InvalidParameter, match=name):
        read_parameters(DwaParameters, "dwa", {name: value})


def test_integers_are_accepted_as_floats_and_reversing_is_allowed():
    parameters = read_parameters(DwaParameters, "dwa", {"max_vel_x": 1, "min_vel_x": -1})
    assert (parameters.max_vel_x, type(parameters.max_vel_x), parameters.min_vel_x) == (1.0, float, -1.0)
