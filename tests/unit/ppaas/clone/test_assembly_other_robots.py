"""Robots that are built otherwise are localized and driven: the frames, mounts and clocks found on real robots.

Frames: odometry of ``base_link`` or ``base_footprint``, joined by the robot's transforms, by its URDF or by neither;
``odom_combined``; a prefix on all frames, also by parameter; frames that only ``tf`` moves; an EKF beside the odometry.
Mounts: upside down, tilted, one laser in front and one behind. Clocks: a lidar whose clock is ahead of the base.
"""

import math
import re

import pytest

from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.base.std_msgs import Time
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.robot_model.describe import describe
from ppaas.robot_model.shapes import placed
from ppaas.transforms.planar import transform_message
from ppaas.transforms.spatial import Rigid
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.other_robots import drive, link, robot

FRONT = placed((0.1, 0.0, 0.2), (0.0, 0.0, 0.0))
LASER = link("base_link", "laser", (0.1, 0.0, 0.2))


def arrived(driving: ClosedLoop) -> bool:
    assert driving.results, driving.texts
    assert driving.worst < 0.15
    return driving.last_status() is Status.SUCCEEDED


def by_amcl(**names: str) -> dict[str, object]:
    return {"parameters": {"amcl": names}}


@pytest.mark.parametrize(
    ("names", "static", "clone"),
    [
        (("odom", "base_footprint"), [TFMessage([link("base_footprint", "base_link", (0, 0, 0.1)), LASER])], {}),
        (("odom", "base_footprint"), [TFMessage([LASER])], {}),
        (("odom", "base_footprint"), [TFMessage([LASER])], by_amcl(base_frame_id="base_footprint")),
        (("odom", "base_link"), [TFMessage([LASER])], by_amcl(base_frame_id="base_footprint")),
        (("odom_combined", "base_link"), [TFMessage([LASER])], {}),
        (("odom_combined", "base_link"), [TFMessage([LASER])], by_amcl(odom_frame_id="odom_combined")),
        (("/odom", "/base_link"), [TFMessage([LASER])], {}),
        (("odom", "mobile_base"), [TFMessage([link("mobile_base", "laser", (0.1, 0.0, 0.2))])], {}),
        (("world", "chassis"), [TFMessage([link("chassis", "laser", (0.1, 0.0, 0.2))])], {}),
        # Two messages of two static publishers.
        (("odom", "base_footprint"), [TFMessage([LASER]), TFMessage([link("base_footprint", "base_link")])], {}),
    ],
)
def test_robot_with_frames_of_other_names_is_driven(names, static, clone):
    assert arrived(drive(robot(names=names, lasers=(("laser", FRONT),)), static=static, **clone))


@pytest.mark.parametrize(
    "clone", [{}, by_amcl(tf_prefix="robot1"), by_amcl(tf_prefix="/robot1/", odom_frame_id="odom")]
)
def test_robot_whose_frames_have_a_prefix_is_driven(clone):
    names, static = (
        ("robot1/odom", "robot1/base_link"),
        [TFMessage([link("robot1/base_link", "robot1/laser", (0.1, 0, 0.2))])],
    )
    driving = drive(robot(names=names, lasers=(("robot1/laser", FRONT),)), static=static, **clone)
    assert arrived(driving)


def test_laser_of_the_model_is_known_with_and_without_the_prefix_of_the_odometry():
    names = ("robot1/odom", "robot1/base_footprint")
    for frame in ("base_scan", "robot1/base_scan"):
        assert arrived(drive(robot(names=names, lasers=((frame, Rigid()),))))


def test_robot_that_publishes_tf_and_no_odometry_is_driven():
    class Silent(ClosedLoop):
        def sense(self, topic, message):
            if topic == "odom":
                topic, message = "tf", self.transform(message)
            super().sense(topic, message)

        @staticmethod
        def transform(odometry):
            pose, stamp = odometry.pose.pose.planar(), odometry.header.stamp
            return TFMessage([transform_message("odom", "base_footprint", pose, stamp)])

    driving = Silent(robot())
    for _ in range(20):
        driving.step()
    driving.send_goal(Pose2D(1.5, 1.5))
    driving.run(30.0)
    # Without the velocity of odometry messages it is not known to stand still, so only the drive counts.
    assert driving.told is not None
    assert driving.told.distance_to(Pose2D(1.5, 1.5)) < 0.3


def test_transforms_of_the_robot_count_and_not_its_odometry_beside_them():
    """As with robot_pose_ekf: ``odom`` carries the raw odometry, and ``tf`` has the fused pose."""

    class Fused(ClosedLoop):
        def sense(self, topic, message):
            if topic == "odom":
                pose, stamp = message.pose.pose.planar(), message.header.stamp
                super().sense("tf", TFMessage([transform_message("odom_combined", "base_link", pose, stamp)]))
                message.pose.pose.position.x += 5.0 * math.sin(self.clock())
            super().sense(topic, message)

    driving = Fused(robot())
    for _ in range(20):
        driving.step()
    driving.send_goal(Pose2D(4.5, 3.0))
    driving.run(40.0)
    assert arrived(driving)


@pytest.mark.parametrize("rpy", [(math.pi, 0.0, 0.0), (3.14, 0.0, 1.5), (0.0, math.pi, 0.0), (0.05, 0.08, 0.0)])
def test_robot_whose_laser_is_upside_down_or_tilted_is_driven(rpy):
    static = [TFMessage([link("base_link", "laser", (0.1, 0.0, 0.4), rpy)])]
    assert arrived(drive(robot(lasers=(("laser", placed((0.1, 0.0, 0.4), rpy)),)), static=static))


def test_laser_upside_down_on_a_mast_of_moving_frames_is_found():
    static = [TFMessage([link("base_link", "mast", (0, 0, 0.3), (0.0, 0.5, 0.0))])]
    static.append(TFMessage([link("mast", "laser", (0, 0, 0.1), (math.pi, -0.5, 0.0))]))
    mount = placed((0, 0, 0.3), (0.0, 0.5, 0.0)) @ placed((0, 0, 0.1), (math.pi, -0.5, 0.0))
    assert arrived(drive(robot(lasers=(("laser", mount),)), static=static))


@pytest.mark.parametrize("ahead", [0.12, 0.2, 0.3])
def test_robot_whose_scans_are_ahead_of_its_odometry_is_driven(ahead):
    """A scan is taken for one of the time by which the clocks are apart, in which the robot has moved on."""
    driving = drive(robot(ahead=ahead))
    assert driving.last_status() is Status.SUCCEEDED, driving.texts
    assert driving.worst < 0.1 + 0.65 * abs(ahead)


def test_robot_with_a_laser_in_front_and_one_behind_is_driven():
    rear = placed((-0.2, 0.0, 0.2), (0.0, 0.0, math.pi))
    static = [TFMessage([LASER, link("base_link", "rear", (-0.2, 0.0, 0.2), (0.0, 0.0, math.pi))])]
    assert arrived(drive(robot(lasers=(("laser", FRONT), ("rear", rear))), static=static))


URDF = """<robot name="r">
  <link name="base_footprint"/>
  <link name="base_link"><collision><geometry><cylinder radius="0.18" length="0.3"/></geometry></collision></link>
  <link name="mast"/><link name="sick"/><link name="wheel"/>
  <joint name="a" type="fixed"><origin xyz="0.05 0 0.1"/>
    <parent link="base_footprint"/><child link="base_link"/></joint>
  <joint name="b" type="fixed"><parent link="base_link"/><child link="mast"/><origin xyz="0.1 0 0.3"/></joint>
  <joint name="c" type="fixed"><parent link="mast"/><child link="sick"/><origin rpy="3.14159265 0 0"/></joint>
  <joint name="d" type="continuous"><parent link="base_link"/><child link="wheel"/></joint>
</robot>"""


@pytest.mark.parametrize(("child", "off"), [("base_footprint", 0.05), ("base_link", 0.0), ("r7/base_footprint", 0.05)])
def test_frames_of_the_urdf_join_what_the_robot_does_not(child, off):
    """A laser whose name says nothing is found too. With odometry of base_footprint, the world moves that frame."""
    mount = placed((0.1 + off, 0.0, 0.4), (math.pi, 0.0, 0.0))
    world = robot(names=("odom", child), lasers=((f"{child.rpartition('/')[0]}/sick".lstrip("/"), mount),))
    driving = drive(world, urdf=describe(URDF.encode()))
    assert driving.results and driving.last_status() is Status.SUCCEEDED, driving.texts
    assert driving.worst < 0.15 + off


@pytest.mark.parametrize(
    ("names", "frame", "change"),
    [
        (("world", "base_link"), "sick", '<link name="world"/><joint name="w" type="fixed">'
         '<parent link="world"/><child link="base_footprint"/></joint></robot>'),
        (("odom", "r1/base_link"), "r1/sick", ""),
    ],
)  # fmt: skip
def test_urdf_with_links_above_the_robot_or_prefixed_names_is_driven(names, frame, change):
    """Simulators fix a robot to a link ``world``, and some files have the prefix in the names of all links."""
    text = URDF.replace("</robot>", change) if change else re.sub(r'(link|link name)="(\w+)"', r'\1="r1/\2"', URDF)
    world = robot(names=names, lasers=((frame, placed((0.1, 0.0, 0.4), (math.pi, 0.0, 0.0))),))
    driving = drive(world, urdf=describe(text.encode()))
    assert driving.results and driving.last_status() is Status.SUCCEEDED, driving.texts


def test_stamps_of_zero_mean_now_in_tf_as_everywhere():
    class Unstamped(ClosedLoop):
        def sense(self, topic, message):
            message.header.stamp = Time()
            super().sense(topic, message)

    driving = Unstamped(robot())
    driving.step()
    driving.graph.inject("tf", TFMessage([transform_message("base_link", "arm", Pose2D(0, 0, 0), Time())]))
    for _ in range(10):
        driving.step()
    driving.send_goal(Pose2D(4.5, 3.0))
    driving.run(40.0)
    assert arrived(driving)
