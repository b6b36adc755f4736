import math

import pytest

from ppaas.controllers.pure_pursuit import PurePursuitParameters
from ppaas.errors import InvalidParameter
from ppaas.parameters import read_parameters


@pytest.mark.parametrize(
    ("wrong", "named"),
    [
        ({"lookahead_dist": 0.0}, "lookahead_dist"),
        ({"lookahead_time": math.nan}, "lookahead_time"),
        ({"min_lookahead_dist": 1.0}, "min_lookahead_dist"),
        ({"cost_scaling_gain": 1.5}, "cost_scaling_gain"),
        ({"rotate_to_heading_angular_vel": 0.1}, "rotate_to_heading_angular_vel"),
        ({"regulated_linear_scaling_min_radius": 0}, "regulated_linear_scaling_min_radius"),
        ({"use_rotate_to_heading": 1}, "use_rotate_to_heading"),
        ({"allow_reversing": True}, "min_vel_x below 0"),
        ({"footprint": [[0.1, 0.1]]}, "footprint"),
        ({"max_allowed_time_to_collision_up_to_carrot": -1.0}, "max_allowed_time_to_collision_up_to_carrot"),
    ],
)
def test_invalid_parameters_are_refused_by_name(wrong, named):
    with pytest.raises(InvalidParameter, match=named):
        read_parameters(PurePursuitParameters, "pure_pursuit", wrong)


def test_reversing_is_valid_with_a_negative_min_vel_x():
    assert PurePursuitParameters(allow_reversing=True, min_vel_x=-0.2).allow_reversing
