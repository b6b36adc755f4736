"""Robots without odometry that make a map: node ``grid_slam`` with the state publisher, on a simulated drive."""

import math
from typing import Any

import numpy as np
import pytest

from ppaas.errors import PPaaSError, TransformError
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.messages.base.std_msgs import Header, String, Time
from ppaas.messages.geometry_msgs import (
    Point,
    Pose,
    PoseWithCovariance,
    Quaternion,
    Twist,
    TwistWithCovariance,
    Vector3,
)
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.frames import SCAN_ODOM, FrameListener
from ppaas.nodes.move_base.pose_watch import PoseWatch
from ppaas.nodes.scan_odometry import PATIENCE, SCANS
from ppaas.nodes.tf.state_publisher import StatePublisherNode, StatePublisherParameters
from ppaas.robot_model.known_models import robot_model
from ppaas.transforms.planar import transform_message
from tests.support.world.mapping_robot import START, HeldJobs, MappingRobot
from tests.support.world.ring_drive import ring_drive

DRIVE = ring_drive()
MOUNT = DRIVE.log.geometry.mount
PERIOD = float(np.median(np.diff(DRIVE.log.stamps)))
WAITING = math.ceil(PATIENCE / PERIOD)


class Handheld(MappingRobot):
    """Robot whose scans come without odometry until `wheels` is true, from a laser whose mount it publishes or not."""

    def __init__(self, *, mount: bool = True, **parameters: Any) -> None:
        self.wheels, self.refusals, self.jumps = "", list[str](), list[float]()
        super().__init__(DRIVE, **parameters)
        self.graph.tap("tf_static", lambda topic, message: self.frames.hear(topic, message, self.clock()))
        model, state = robot_model("turtlebot2"), StatePublisherParameters()
        self.graph.add(lambda context: StatePublisherNode(context, model, state))
        self.laser = "laser" if mount else "velodyne"
        self.last: Pose2D | None = None
        self.graph.tap("tf", self._watch)

    def scan_message(self, number: int, stamp: float | None = None) -> Any:
        message = super().scan_message(number, stamp)
        message.header.frame_id = self.laser
        return message

    def _watch(self, topic: str, message: TFMessage) -> None:
        """Note how far the robot is displaced in the map at once, as a consumer of ``tf`` sees it."""
        stamp = self.frames.tree.common_time("map", "base_link")
        if stamp is None:
            return
        now = self.frames.tree.lookup("map", "base_link", stamp)
        if self.last is not None:
            self.jumps.append(self.last.distance_to(now) + abs(wrap_angle(self.last.theta - now.theta)))
        self.last = now

    def odom(self, pose: Pose2D, stamp: float | None = None) -> None:
        """Publish odometry by the wheels that there are, which began elsewhere: a message, a transform, or nothing."""
        away = Pose2D(3.0, -2.0, 2.5) @ pose
        moment = Time.of(self.clock())
        if self.wheels == "tf":
            self.graph.inject("tf", TFMessage([transform_message("odom_combined", "base_footprint", away, moment)]))
        elif self.wheels:
            turn = Quaternion(z=math.sin(0.5 * away.theta), w=math.cos(0.5 * away.theta))
            at = Pose(Point(math.nan if self.wheels == "broken" else away.x, away.y, 0.0), turn)
            header, still = Header(stamp=moment, frame_id="odom"), TwistWithCovariance(Twist(Vector3(), Vector3()))
            child = "base_link" if self.wheels == "broken" else self.wheels
            message = Odometry(header, child, PoseWithCovariance(at), still)
            try:
                self.graph.inject("odom", message)
            except PPaaSError as error:
                self.refusals.append(str(error))

    def drive_on(self, count: int) -> None:
        for _ in range(count):
            try:
                self.step()
            except TransformError as error:  # a client gets it as a status
                self.refusals.append(str(error))
                self.next += 1

    @property
    def status(self) -> str:
        latched = self.graph.latched("grid_slam/status")
        return latched.data if isinstance(latched, String) else ""

    @property
    def map_error(self) -> float:
        """Error of the newest pose in the map; the map begins with the pose of the laser in its own frame [m]."""
        first, last = (Pose2D(*DRIVE.true[number].tolist()) for number in (0, self.next - 1))
        return Pose2D(*self.poses()[-1].tolist()).distance_to(first.inverse() @ last)


def test_a_robot_with_scans_alone_is_mapped_from_its_first_scan() -> None:
    robot = Handheld()
    robot.drive_on(WAITING - 2)
    assert not robot.poses().size and "scans wait for odometry" in robot.status
    robot.drive_on(4)
    assert len(robot.poses()) == robot.next, "the scans that waited are used too"
    assert "map is made of scans alone" in robot.status and "not driven" in robot.status
    robot.drive_on(len(DRIVE.log) - robot.next)
    assert robot.map_error < 0.05
    assert robot.refusals == []


def test_consumers_see_the_pose_at_the_time_of_the_last_scan() -> None:
    robot = Handheld()
    robot.drive_on(WAITING + 40)
    tree = robot.frames.tree
    assert tree.common_time("map", "base_link") == pytest.approx(robot.clock())
    seen = tree.lookup("map", "base_link")
    assert seen == pytest.approx(robot.poses()[-1], abs=1e-6)
    assert robot.frames.odom == SCAN_ODOM


@pytest.mark.parametrize("wheels", ["base_link", "base_footprint", "tf"])
def test_mapping_goes_over_to_odometry_without_a_jump(wheels: str) -> None:
    robot = Handheld()
    robot.drive_on(WAITING + 60)
    robot.jumps.clear()
    robot.wheels = wheels
    robot.drive_on(60)
    assert robot.status == ""
    assert robot.frames.odom == ("odom_combined" if wheels == "tf" else "odom")
    window = DRIVE.true[robot.next - 60 : robot.next]
    steps = [Pose2D(*a).inverse() @ Pose2D(*b) for a, b in zip(window[:-1].tolist(), window[1:].tolist(), strict=True)]
    largest = max(math.hypot(step.x, step.y) + abs(step.theta) for step in steps)
    assert max(robot.jumps) < 2.0 * largest + 0.05, "one step is taken twice: odometry begins after the last scan"
    assert robot.map_error < 0.05
    robot.drive_on(len(DRIVE.log) - robot.next)
    assert robot.map_error < 0.05
    assert robot.refusals == []


def test_odometry_in_time_leaves_the_robot_as_it_always_was() -> None:
    robot = Handheld()
    robot.drive_on(WAITING - 5)
    robot.wheels = "base_link"
    robot.drive_on(WAITING)
    assert robot.status == "" and robot.frames.odom == "odom"


def test_few_scans_over_a_long_time_do_not_begin_a_map() -> None:
    robot = Handheld()
    for _ in range(SCANS + 2):
        robot.clock.advance(PATIENCE + 1.0)
        robot.graph.inject("scan", robot.scan_message(0))
    assert "scans alone" not in robot.status and not robot.poses().size


def test_odometry_that_is_refused_is_mended_not_replaced() -> None:
    robot = Handheld()
    robot.wheels = "broken"
    robot.drive_on(2 * WAITING)
    assert robot.refusals and not robot.poses().size
    assert "is refused" in robot.status or "scans wait for odometry" in robot.status


def test_a_transform_of_odometry_by_another_name_is_mended_not_replaced() -> None:
    robot = Handheld(odom_frame="odometry", base_frame="body")
    robot.wheels = "tf"
    robot.drive_on(2 * WAITING)
    assert not robot.poses().size


def test_a_laser_without_a_transform_is_the_robot_while_there_is_no_odometry() -> None:
    robot = Handheld(mount=False)
    robot.drive_on(len(DRIVE.log))
    assert len(robot.refusals) <= WAITING + 1 and "velodyne" in robot.refusals[0]
    assert robot.frames.mount("velodyne").x == 0.0
    first, last = (Pose2D(*DRIVE.true[number].tolist()) @ MOUNT for number in (WAITING, robot.next - 1))
    assert Pose2D(*robot.poses()[-1].tolist()).distance_to(first.inverse() @ last) < 0.1


def test_a_robot_with_a_prefix_that_nothing_else_names_has_its_laser_where_its_transforms_say() -> None:
    robot = Handheld(mount=False)
    robot.laser = "robot1/laser"
    mount = TFMessage([transform_message("robot1/base_link", "robot1/laser", MOUNT, Time())])
    robot.graph.inject("tf_static", mount)
    robot.drive_on(WAITING + 60)
    assert robot.frames.mount("robot1/laser") == robot.frames.mount("laser"), "both have the same mount"
    robot.wheels = "robot1/base_link"
    robot.refusals.clear()
    robot.drive_on(120)
    assert robot.status == "" and robot.refusals == []
    base = Pose2D(*robot.poses()[-1].tolist())
    first, last = (Pose2D(*DRIVE.true[number].tolist()) for number in (WAITING, robot.next - 1))
    assert base.distance_to(first.inverse() @ last) < 0.1


def test_the_mount_of_a_laser_is_asked_for_once_there_is_odometry_and_then_used() -> None:
    robot = Handheld(mount=False)
    robot.drive_on(WAITING + 60)
    robot.wheels = "base_link"
    robot.drive_on(10)
    assert "publish 'base_link' → 'velodyne' on 'tf_static'" in robot.refusals[-1]
    assert "publish 'base_link' → 'velodyne' on 'tf_static'" in robot.status
    robot.graph.inject("tf_static", TFMessage([transform_message("base_link", "velodyne", MOUNT, Time())]))
    robot.refusals.clear()
    robot.drive_on(120)
    assert robot.status == "" and robot.refusals == []
    mapper = robot.node._mapper
    assert mapper is not None and mapper.key_frames.geometry.mount == pytest.approx(MOUNT, abs=1e-9)
    base = Pose2D(*robot.poses()[-1].tolist())
    first, last = (Pose2D(*DRIVE.true[number].tolist()) for number in (WAITING, robot.next - 1))
    assert base.distance_to((first @ MOUNT).inverse() @ last) < 0.1


def test_another_container_goes_on_at_once() -> None:
    robot = Handheld()
    robot.drive_on(WAITING + 60)
    state, log = robot.node.checkpoint(), robot.node.whole_log()
    assert state is not None and log is not None
    other = Handheld()
    other.next = robot.next
    other.clock.advance(robot.clock() - START)
    other.node.restore(state)
    other.node.restore_log(log.entries)
    other.drive_on(20)
    assert len(other.poses()) == 20
    assert other.map_error < 0.05 and "scans alone" in other.status
    other.wheels = "base_link"
    other.drive_on(20)
    assert other.status == "" and other.map_error < 0.05


def test_odometry_that_comes_while_another_container_rebuilds_the_map_is_used() -> None:
    robot = Handheld()
    robot.drive_on(WAITING + 60)
    state, log = robot.node.checkpoint(), robot.node.whole_log()
    assert state is not None and log is not None
    jobs = HeldJobs()
    other = Handheld(worker=jobs)
    other.next, other.wheels = robot.next, "base_link"
    other.clock.advance(robot.clock() - START)
    other.node.restore(state)
    other.node.restore_log(log.entries)
    other.drive_on(3)
    jobs.release()
    other.drive_on(20)
    assert other.status == "" and other.map_error < 0.05
    assert other.node._mapper is not None and other.node._mapper.parts.is_whole


def test_a_clock_that_is_set_back_does_not_end_the_map() -> None:
    robot = Handheld()
    robot.drive_on(WAITING + 40)
    count = len(robot.poses())
    for number in range(robot.next, robot.next + 40):
        robot.clock.advance(PERIOD)
        try:
            robot.graph.inject("scan", robot.scan_message(number, robot.clock() - 3600.0))
        except PPaaSError as error:
            robot.refusals.append(str(error))
    assert len(robot.poses()) >= count + 35
    assert len(robot.refusals) <= 2


def test_goals_name_what_is_missing() -> None:
    frames = FrameListener()
    robot = Handheld()
    robot.graph.tap("tf", lambda topic, message: frames.hear(topic, message, robot.clock()))
    robot.drive_on(WAITING + 20)
    with pytest.raises(TransformError, match=r"scans alone.*not driven; publish nav_msgs/Odometry on 'odom'"):
        PoseWatch(frames, 1.0).check(robot.clock())
    robot.wheels = "base_link"
    robot.drive_on(3)
    PoseWatch(frames, 1.0).check(robot.clock())
