import math

import pytest

from ppaas.errors import InvalidInput, TransformError
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Pose, Twist, Vector3
from ppaas.messages.ppaas_msgs import RobotStates
from ppaas.nodes.other_robots import FASTEST, LARGEST, OTHERS_MARGIN, others_of

MAP = Header(frame_id="/map")
POSE = Pose.of(Pose2D(1.0, 2.0, math.pi / 2))


def driving(speed):
    return Twist(linear=Vector3(x=speed))


def test_other_robot_has_its_heading_velocity_and_radius():
    (other,) = others_of(RobotStates(MAP, [POSE], [driving(-0.5)], [0.3]), 0.18)
    assert other == pytest.approx((1.0, 2.0, 0.0, -0.5, 0.3 + OTHERS_MARGIN), abs=1e-9)


def test_other_robot_defaults_to_rest_and_own_radius():
    for message in (RobotStates(MAP, [POSE]), RobotStates(MAP, [POSE], [Twist()], [0.0])):
        assert others_of(message, 0.18)[0] == pytest.approx((1.0, 2.0, 0.0, 0.0, 0.18 + OTHERS_MARGIN), abs=1e-9)


def test_velocity_and_radius_are_limited():
    (other,) = others_of(RobotStates(MAP, [POSE], [driving(1e6)], [1e6]), 0.18)
    assert (math.hypot(other.vx, other.vy), other.radius) == pytest.approx((FASTEST, LARGEST + OTHERS_MARGIN))


@pytest.mark.parametrize(
    "wrong",
    [
        RobotStates(MAP, [POSE], [driving(math.nan)], [0.2]),
        RobotStates(MAP, [POSE], [driving(0.1)], [math.inf]),
        RobotStates(MAP, [POSE], [driving(0.1)], [-0.1]),
        RobotStates(MAP, [POSE], [driving(0.1)] * 2),
        RobotStates(MAP, [POSE, POSE], [], [0.2]),
        RobotStates(MAP, [Pose.of(Pose2D(math.nan, 0.0))]),
    ],
)
def test_non_finite_or_mismatched_lists_are_refused(wrong):
    with pytest.raises(InvalidInput):
        others_of(wrong, 0.18)


def test_robots_in_another_frame_are_refused():
    with pytest.raises(TransformError, match="odom"):
        others_of(RobotStates(Header(frame_id="odom"), [POSE]), 0.18)
