"""Reasons why a robot that has a goal does not drive, in the status of the goal.

What can be missing: odometry, a transform of it, scans, a usable scan, a transform of the laser, localization itself.
"""

import re

import pytest

from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Time
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.frames import FrameListener, FrameNames
from ppaas.nodes.move_base.pose_watch import PoseWatch
from ppaas.transforms.planar import transform_message
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.other_robots import GOAL, OtherRobot, robot
from tests.support.world.planar_world import World


class Watched:
    """A watch and the frames that it watches."""

    def __init__(self, names: FrameNames | None = None) -> None:
        self.frames = FrameListener(names)
        self.watch = PoseWatch(self.frames, 1.0)

    def hear(self, parent: str, child: str, now: float) -> None:
        self.frames.hear("tf", TFMessage([transform_message(parent, child, Pose2D(0, 0), Time.of(now))]), now)

    def reason(self, now: float) -> str:
        try:
            self.watch.check(now)
        except PPaaSError as error:
            return str(error)
        return ""


def test_missing_odometry_is_named_with_what_to_publish():
    watched = Watched()
    assert watched.reason(5.0) == (
        "no odometry yet: publish nav_msgs/Odometry on 'odom', or the transform 'odom' → 'base_link' on 'tf'"
    )
    watched.hear("odom", "base_link", 5.0)
    assert watched.reason(7.5) == "no odometry for 2.5 s"


def test_odometry_of_other_frames_than_those_of_the_file_is_named():
    watched = Watched(FrameNames(odom="odom_combined"))
    watched.hear("odom", "base_link", 5.0)
    watched.watch.odometry_came(5.0, "odom", "base_link")
    assert watched.reason(5.0) == (
        "no odometry yet: no transform connects 'odom_combined' with 'base_link', but the odometry moves 'base_link' "
        "in 'odom': set odom_frame_id and base_frame_id of amcl (or odom_frame and base_frame of grid_slam) to "
        "these, or leave them out"
    )


def test_odometry_that_is_refused_is_missing_although_tf_moves_the_robot():
    watched = Watched()
    watched.hear("map", "odom", 5.0)
    watched.hear("odom", "base_link", 5.0)
    watched.watch.odometry_came(5.0, "odom", "base_link")
    watched.watch.odometry_refused(PPaaSError("the twist of odometry must be finite"))
    watched.hear("odom", "base_link", 6.5)
    assert watched.reason(6.0) == ""
    assert watched.reason(6.5) == "no odometry for 1.5 s: odometry is refused: the twist of odometry must be finite"
    watched.hear("map", "odom", 6.5)
    watched.watch.odometry_came(6.5, "odom", "base_link")
    assert watched.reason(6.5) == ""


def test_missing_localization_is_explained_by_the_scans():
    watched = Watched()
    watched.hear("odom", "base_link", 5.0)
    assert watched.reason(5.0) == ("no localization yet: no scan has come: publish sensor_msgs/LaserScan on 'scan'")
    watched.watch.scan_refused(PPaaSError("unknown frame 'laser'"))
    assert watched.reason(5.0) == "no localization yet: scans are refused: unknown frame 'laser'"
    watched.watch.scan_came(5.0)
    assert watched.reason(5.0) == "no localization yet"
    watched.watch.localization = "scans are stamped 3.0 s ahead"
    assert watched.reason(5.0) == "no localization yet: scans are stamped 3.0 s ahead"
    watched.hear("map", "odom", 5.0)
    assert watched.reason(5.5) == ""
    watched.hear("odom", "base_link", 7.5)
    assert watched.reason(7.5) == "no localization for 2.5 s: the last scan came 2.5 s ago"


def test_a_robot_that_localizes_itself_is_believed_at_once_when_it_says_that_it_is_not():
    watched = Watched()
    watched.watch.expects_scans = False
    watched.hear("odom", "base_link", 5.0)
    watched.hear("map", "odom", 5.0)
    assert watched.reason(5.0) == ""
    watched.watch.localization = "states of the AGV are left out"
    assert watched.reason(5.0) == "not localized: states of the AGV are left out"
    watched.watch.localization = ""
    assert watched.reason(5.0) == ""


def blind(scan):
    scan.ranges = [None] * len(scan.ranges)
    return scan


def upright(scan):
    scan.header.frame_id = "nowhere"
    return scan


def degrees(scan):
    scan.angle_increment = 2.0
    return scan


def late(scan):
    scan.header.stamp = Time.of(scan.header.stamp.seconds() - 3.0)
    return scan


def ahead(scan):
    scan.header.stamp = Time.of(scan.header.stamp.seconds() + 3600.0)
    return scan


class Broken(OtherRobot):
    """A robot whose scans are spoilt from a time on."""

    spoil = staticmethod(lambda scan: scan)

    def scan(self, stamp):
        return self.spoil(super().scan(stamp))


@pytest.mark.parametrize(
    ("spoil", "why"),
    [
        (blind, "no beam of the scan has a reading"),
        (upright, "unknown frame 'nowhere'; known: base_link, base_scan"),
        (degrees, "in radians"),
        (late, "3.0 s before the newest odometry"),
        (ahead, r"scans are stamped (3599\.9|3600\.0) s ahead"),
    ],
)
def test_robot_that_stands_says_within_2_s_why(spoil, why):
    driving = Quiet(Broken(robot().grid, robot().pose))
    for _ in range(20):
        driving.step()
    driving.send_goal(GOAL)
    for _ in range(40):
        driving.step()
    driving.world.spoil = spoil
    driving.texts.clear()
    for _ in range(40):
        driving.step()
    driving.texts.clear()
    for _ in range(20):
        driving.step()
    assert driving.texts
    for text in driving.texts:
        assert text.startswith("waiting: no localization for")
        assert re.search(why, text), text


class Quiet(ClosedLoop):
    """A robot that does not mind when its messages are refused."""

    def sense(self, topic, message):
        try:
            super().sense(topic, message)
        except PPaaSError:
            return


def test_robot_without_scans_says_so_from_the_start():
    class Laserless(Quiet):
        def sense(self, topic, message):
            if topic != "scan":
                super().sense(topic, message)

    driving = Laserless(World(robot().grid, robot().pose))
    driving.send_goal(GOAL)
    for _ in range(40):
        driving.step()
    driving.texts.clear()
    for _ in range(20):
        driving.step()
    assert driving.texts == {"waiting: no localization yet: no scan has come: publish sensor_msgs/LaserScan on 'scan'"}
