"""Scans that are taken: their laser, and other robots in them."""

import math

import numpy as np
import pytest

from ppaas.errors import TransformError
from ppaas.geometry import Pose2D
from ppaas.mapping.parameters import SlamParameters
from ppaas.mapping.serialization.mapping_file import pack_mapping, unpack_mapping
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Pose
from ppaas.messages.ppaas_msgs import RobotStates
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.nodes.grid_slam.laser import MappingLaser
from ppaas.nodes.grid_slam.parameters import GridSlamParameters
from ppaas.nodes.grid_slam.posegraph_services import PoseGraphStore
from ppaas.nodes.grid_slam.scan_intake import blindness_status
from ppaas.nodes.robot_scans import RobotScan
from ppaas.planar_poses import compose
from tests.support.world.mapping_robot import MappingRobot
from tests.support.world.ring_drive import ring_drive

RANGES: list[float | None] = [2.0, None, math.inf, math.nan, 8.0, 9.5, 6.5, 0.0, 0.02, -math.inf]


def scan_of(ranges: list[float | None]) -> LaserScan:
    return LaserScan(
        Header(frame_id="laser"), angle_min=-0.5, angle_max=0.4, angle_increment=0.1, range_min=0.05, range_max=8.0,
        ranges=ranges,
    )  # fmt: skip


def reaches(parameters: SlamParameters, *, frees: bool) -> tuple[list[float], list[bool]]:
    """Return the distances of the points of a scan [m], and which have a reading."""
    scan = RobotScan(scan_of(RANGES), Pose2D(0.0, 0.0, 0.0), 1.0, 1.0)
    found = MappingLaser.of(scan, parameters).points(scan, Pose2D(0.0, 0.0, 0.0), 1.0, frees=frees)
    return [round(float(each), 3) for each in np.hypot(*found.points.T)], found.valid.tolist()


def test_beams_that_hit_nothing_show_free_space_if_wanted() -> None:
    readings = [True, False, False, False, False, False, True, False, False, False]
    assert reaches(SlamParameters(), frees=False) == ([2.0, 0, 0, 0, 0, 0, 6.5, 0, 0, 0], readings)
    assert reaches(SlamParameters(), frees=True) == ([2.0, 8.0, 8.0, 8.0, 8.0, 8.0, 6.5, 0, 0, 0], readings)


def test_beams_are_free_up_to_the_largest_range_that_is_used() -> None:
    found, readings = reaches(SlamParameters(max_laser_range=6.0), frees=True)
    assert found == [2.0, 6.0, 6.0, 6.0, 6.0, 6.0, 6.0, 0, 0, 0]
    assert readings == [True] + [False] * 9


@pytest.mark.parametrize(
    ("parameters", "frees"),
    [({}, False), ({"inf_is_valid": True}, True), ({"maxUrange": 7.0}, True), ({"maxUrange": 8.0}, False),
     ({"max_laser_range": 7.0}, False)],
)  # fmt: skip
def test_beams_are_free_by_the_parameters_of_costmap_2d_and_gmapping(parameters: dict[str, float], frees: bool) -> None:
    assert GridSlamParameters(**parameters).frees(8.0) is frees


def test_a_scan_without_readings_is_explained_as_the_doctor_does() -> None:
    assert blindness_status(scan_of([2.0] * 10)) == ""
    text = blindness_status(scan_of([math.inf] * 10))
    assert text.startswith(
        "nothing is mapped: All ranges of the scans of 'laser' are null, NaN or infinite. See whether"
    )
    assert "set 'inf_is_valid' of grid_slam" in text


KNOWN, SCANS, RADIUS = 10, 50, 0.5
"""Scans of the published map, scans of the robot, and radius of the other robot with its margin [m]."""


@pytest.fixture(scope="module")
def published():
    robot = MappingRobot(ring_drive())
    robot.step(KNOWN)
    return b"".join(pack_mapping(robot.node._mapping()))


def known(published):
    """Return the number of key frames of the published map."""
    return len(unpack_mapping(published).frames)


def drive(published, frame="map"):
    """Return a robot that continues a map beside another robot, which stands where the scans end."""
    robot = MappingRobot(ring_drive(), graphs=PoseGraphStore(load=lambda _name: published), map_file_name="ring")
    heard = []
    robot.graph.tap("grid_slam/shared_pose", lambda _topic, message: heard.append(message))
    for _ in range(SCANS):
        states = RobotStates(Header(frame_id=frame), [Pose.of(standing())], [], [RADIUS - 0.1])
        robot.graph.inject("robots", states)
        robot.step()
    return robot, heard


def standing():
    """Return the place of the other robot: a pillar that the first robot passes, in the map frame."""
    start, (x, y) = ring_drive().true[0], (4.2, 0.15)
    odometry = Pose2D(*ring_drive().log.odometry[0].tolist())
    return odometry @ Pose2D(*start.tolist()).inverse() @ Pose2D(x, y, 0.0)


def points_on_it(robot, first):
    """Return the number of points, of the key frames from ``first`` on, that are well within the other robot."""
    frames = robot.node._mapper.key_frames
    x, y = np.moveaxis(frames.points[first:], -1, 0)
    points = compose(frames.poses[first:, None], np.stack((x, y, np.zeros_like(x)), axis=-1))
    away = np.hypot(points[..., 0] - standing().x, points[..., 1] - standing().y)
    return int((frames.valid[first:] & (away < RADIUS - 0.1)).sum())


def test_points_on_another_robot_do_not_enter_the_map(published):
    robot, heard = drive(published)
    assert robot.true_error() < 0.05
    assert len(robot.node._mapper.key_frames) > known(published) + 3
    assert points_on_it(robot, known(published)) == 0
    assert len(heard) == SCANS


@pytest.mark.parametrize("home", ["cloud", "robot"])
def test_a_node_that_replaces_another_is_in_the_same_frame(published, home):
    before, _ = drive(published)
    given = {"map_file_name": "ring"}
    if home == "cloud":
        given["graphs"] = PoseGraphStore(load=lambda _name: published)
    robot, heard = MappingRobot(ring_drive(), **given), []
    robot.graph.tap("grid_slam/shared_pose", lambda _topic, message: heard.append(message))
    change, state = before.node.log_change(), before.node.checkpoint()
    robot.node.restore(state)
    robot.node.restore_log(change.entries)
    robot.next = before.next
    robot.step(3)
    assert len(heard) == 3


def test_a_map_of_its_own_has_no_frame_in_common():
    robot, heard = MappingRobot(ring_drive()), []
    robot.graph.tap("grid_slam/shared_pose", lambda _topic, message: heard.append(message))
    for _ in range(SCANS):
        robot.graph.inject("robots", RobotStates(Header(frame_id="map"), [Pose.of(standing())], [], [RADIUS - 0.1]))
        robot.step()
    assert points_on_it(robot, 0) > 20
    assert heard == []


def test_after_clear_the_frame_is_another_one(published):
    robot, heard = drive(published)
    count = len(heard)
    robot.call("clear")
    robot.step(3)
    assert len(heard) == count


def test_robots_in_another_frame_are_refused(published):
    with pytest.raises(TransformError, match="must be in frame 'map'"):
        drive(published, "odom")


def test_old_positions_are_not_used(published):
    robot = MappingRobot(ring_drive(), graphs=PoseGraphStore(load=lambda _name: published), map_file_name="ring")
    robot.graph.inject("robots", RobotStates(Header(frame_id="map"), [Pose.of(standing())], [], [RADIUS - 0.1]))
    robot.step(SCANS)
    assert points_on_it(robot, known(published)) > 20
