"""Velocities with a header."""

import pytest

from ppaas.messages import decode, encode
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Twist, TwistStamped, Vector3
from ppaas.wire.stamped_twists import may_be_named, stamping


def test_a_twist_gets_the_frame_and_the_time_of_the_call() -> None:
    times = iter((12.5, 13.0))
    stamp, twist = stamping('a "frame"', lambda: next(times)), Twist(Vector3(x=0.5))
    for seconds in (Time(12, 500_000_000), Time(13, 0)):
        expected = TwistStamped(Header(stamp=seconds, frame_id='a "frame"'), twist)
        assert decode(TwistStamped, stamp(encode(twist))) == expected


@pytest.mark.parametrize(
    ("kind", "name", "may"),
    [
        ("geometry_msgs/Twist", "geometry_msgs/Twist", True),
        ("geometry_msgs/Twist", "geometry_msgs/TwistStamped", True),
        ("geometry_msgs/TwistStamped", "geometry_msgs/Twist", False), ("nav_msgs/Path", "nav_msgs/Path", True),
        ("geometry_msgs/Pose", "geometry_msgs/PoseStamped", False),
    ],
)  # fmt: skip
def test_a_topic_of_twists_may_also_be_named_by_its_stamped_type(kind: str, name: str, may: bool) -> None:
    assert may_be_named(kind, name) is may
