import math

import pytest

from ppaas.controllers.mppi_parameters import MppiParameters
from ppaas.errors import InvalidParameter
from ppaas.parameters import read_parameters

SQUARE = [[0.2, 0.2], [-0.2, 0.2], [-0.2, -0.2], [0.2, -0.2]]


def test_defaults_are_valid_and_a_json_footprint_is_accepted():
    assert MppiParameters().footprint == ()
    assert read_parameters(MppiParameters, "mppi", {"footprint": SQUARE}).footprint[1] == (-0.2, 0.2)
    assert read_parameters(MppiParameters, "mppi", {"footprint": SQUARE[::-1]}).footprint[0] == (0.2, -0.2)


@pytest.mark.parametrize(
    ("wrong", "named"),
    [
        ({"batch_size": 0}, "batch_size"),
        ({"batch_size": 7}, "batch_size"),
        ({"batch_size": 1 << 20}, "batch_size"),
        ({"time_steps": 0}, "time_steps"),
        ({"model_dt": 0.0}, "model_dt"),
        ({"temperature": math.nan}, "temperature"),
        ({"iteration_count": 0}, "iteration_count"),
        ({"gamma": -1.0}, "gamma"),
        ({"vx_std": "much"}, "vx_std"),
        ({"max_vel_x": -1.0}, "max_vel_x"),
        ({"min_vel_x": 0.5}, "min_vel_x"),
        ({"min_vel_theta": 2.0}, "min_vel_theta"),
        ({"command_delay": -0.1}, "command_delay"),
        ({"command_delay": 60.0}, "command_delay"),
        ({"allow_unknown": 1}, "allow_unknown"),
        ({"seed": -1}, "seed"),
        ({"footprint": [[0.1, 0.1], [0.2, 0.2]]}, "footprint"),
        ({"footprint": [[1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0]]}, "footprint"),
        ({"footprint": [[0.2, math.inf], [-0.2, 0.2], [-0.2, -0.2]]}, "footprint"),
        ({"footprint": "box"}, "footprint"),
        ({"footprint": [[0.2, 0.2, 0.0], [-0.2, 0.2, 0.0], [-0.2, -0.2, 0.0]]}, "footprint"),
        ({"footprint": [[0.2, True], [-0.2, 0.2], [-0.2, -0.2]]}, "footprint"),
    ],
)
def test_invalid_parameters_are_refused_by_name(wrong, named):
    with pytest.raises(InvalidParameter, match=named):
        read_parameters(MppiParameters, "mppi", wrong)
