"""Arguments of ``ppaas bridge ros2``."""

from ppaas.wire.ros.graph import ROS_2_RELEASES
from robots.bridges.cli.ros2 import RELEASES


def test_every_known_release_may_be_named():
    assert RELEASES == ROS_2_RELEASES
