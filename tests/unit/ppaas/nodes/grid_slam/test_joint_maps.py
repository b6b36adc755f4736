"""Robots that receive the joint map of several robots and go on with it."""

import base64
from typing import NamedTuple

import numpy as np
import pytest

from ppaas.errors import Conflict, InvalidInput, QuotaExceeded, Unavailable
from ppaas.geometry import Pose2D
from ppaas.mapping.merging.united import frame_ids
from ppaas.mapping.serialization.mapping_file import pack_mapping, unpack_mapping
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Pose
from ppaas.messages.ppaas_msgs import RobotStates
from ppaas.messages.slam_toolbox import GetPoseGraphRequest, UseJointMapRequest
from ppaas.nodes.grid_slam import joint_maps
from ppaas.nodes.key_frame_path import key_frames_of
from tests.support.world.joint_maps import joint_map, motion_between, start_of
from tests.support.world.mapping_robot import HeldJobs, MappingRobot
from tests.support.world.merge_drives import first_drive, second_drive

MET, LATER = 60, 12
"""Number of scans of each robot at the merge, and of those that come until it is known."""


def file_of(robot):
    return b"".join(pack_mapping(robot.node._mapping()))


def pages(file, size=50_000, robots=("tb2",)):
    return [
        UseJointMapRequest(at, len(file), base64.b64encode(file[at : at + size]).decode(), list(robots))
        for at in range(0, len(file), size)
    ]


def send(robot, file, **options):
    """Send a joint map; return the last response."""
    return [robot.call("grid_slam/use_joint_map", page) for page in pages(file, **options)][-1]


def begin_sending(robot, file, replies):
    """Send a joint map to a robot whose jobs are held; responses are appended to ``replies`` as they come."""
    for page in pages(file):
        robot.graph.call("grid_slam/use_joint_map", page, replies.append)


def listen(robot, topic):
    heard = []
    robot.graph.tap(topic, lambda _topic, message: heard.append(message))
    return heard


class Met(NamedTuple):
    """Robots that have met: the younger one, its joint map, and what it published."""

    robot: MappingRobot
    file: bytes
    before: dict
    answer: object
    after: dict
    heard: dict


def state_of(robot):
    return {
        "odom": robot.node._map_to_odom, "map": robot.map(), "shown": robot.displayed(),
        "ids": frame_ids(robot.node._mapping()),
        "frame": robot.call("pose_graph", GetPoseGraphRequest()).frame,
        "checkpoint": robot.node.checkpoint(),
    }  # fmt: skip


@pytest.fixture(scope="module")
def joint():
    """The file of the joint map of both robots."""
    robots = MappingRobot(first_drive()), MappingRobot(second_drive())
    for robot in robots:
        robot.step(MET)
    return b"".join(pack_mapping(joint_map(*((robot.drive, robot.node._mapping()) for robot in robots))))


@pytest.fixture(scope="module")
def met(joint):
    robot = MappingRobot(second_drive())
    heard = {topic: listen(robot, topic) for topic in ("grid_slam/status", "key_frames", "grid_slam/shared_pose")}
    robot.step(MET)
    stored = robot.node.log_change()
    robot.step(LATER)
    before = state_of(robot)
    answer = send(robot, joint)
    after = state_of(robot)
    robot.step(3)
    return Met(robot, joint, before, answer, after, heard | {"log": stored})


def test_robot_goes_on_where_it_was_with_all_that_it_mapped(met):
    joint = unpack_mapping(met.file)
    assert set(met.after["ids"]) == set(met.before["ids"]) | set(frame_ids(joint))
    assert met.answer.key_frames == len(met.after["ids"]) > len(joint.frames)
    motion = Pose2D(met.answer.motion.x, met.answer.motion.y, met.answer.motion.theta)
    np.testing.assert_allclose(met.after["odom"], motion @ met.before["odom"], atol=1e-6)
    np.testing.assert_allclose(motion, motion_between(first_drive(), second_drive()), atol=1e-6)


def test_robot_is_in_the_frame_of_the_first_one(met):
    true = Pose2D(*second_drive().true[met.robot.next - 1].tolist())
    assert met.robot.in_map.distance_to(start_of(first_drive()).inverse() @ true) < 0.1
    assert met.after["frame"] != met.before["frame"]


def test_map_of_both_is_published_at_once(met):
    known = [(state["map"].data >= 0).sum() for state in (met.before, met.after)]
    assert known[1] > 1.2 * known[0]
    np.testing.assert_array_equal(met.after["shown"].data, met.after["map"].data)


def test_status_says_that_the_frame_is_another_one(met):
    texts = [message.data for message in met.heard["grid_slam/status"]]
    [text] = [text for text in texts if "joined" in text]
    assert text.startswith("the map is joined with that of tb2; its frame is another one: the former origin is at")
    assert texts[-1] == ""


def test_key_frames_keep_their_times(met):
    before, after = (key_frames_of(message) for message in met.heard["key_frames"][-2:])
    common = np.intersect1d(before.stamps, after.stamps)
    assert len(common) == len(before.stamps) > 20
    np.testing.assert_array_equal(after.motion_since(before, common[0]).theta, met.answer.motion.theta)


def test_pose_is_shared_in_the_frame_of_the_joint_map(met):
    poses = met.heard["grid_slam/shared_pose"]
    assert len(poses) == 3
    assert {message.header.frame_id for message in poses} == {met.after["frame"]}


def test_replacement_continues_the_joint_map(met):
    change = met.robot.node.log_change()
    entries = {entry.number: entry for entry in (*met.heard["log"].entries, *change.entries)}
    for number in change.obsolete:
        entries.pop(number, None)
    robot = MappingRobot(second_drive())
    shared = listen(robot, "grid_slam/shared_pose")
    robot.node.restore(met.robot.node.checkpoint())
    robot.node.restore_log([entries[number] for number in sorted(entries)])
    robot.next = met.robot.next
    robot.step(2)
    assert set(frame_ids(robot.node._mapping())) >= set(met.after["ids"])
    assert {message.header.frame_id for message in shared} == {met.after["frame"]}


def test_joint_map_waits_until_loops_are_closed(joint):
    jobs = HeldJobs()
    robot = MappingRobot(second_drive(), worker=jobs)
    while not jobs.held:
        robot.step()
    replies = []
    begin_sending(robot, joint, replies)
    assert len(jobs.held) == 1
    jobs.release()
    robot.clock.advance(joint_maps.RETRY)
    robot.graph.run_due()
    assert len(jobs.held) == 1
    jobs.release()
    assert replies[-1].key_frames >= len(unpack_mapping(joint).frames)


def test_map_that_was_cleared_meanwhile_is_not_joined(joint):
    jobs = HeldJobs()
    robot = MappingRobot(second_drive(), worker=jobs)
    robot.step(20)
    jobs.release()
    replies = []
    begin_sending(robot, joint, replies)
    robot.call("clear")
    jobs.release()
    assert isinstance(replies[-1], Unavailable)
    assert robot.node._mapper is None


def test_map_that_was_cleared_while_a_joint_one_waited_is_not_joined_and_the_next_one_is(joint):
    jobs = HeldJobs()
    robot = MappingRobot(second_drive(), worker=jobs)
    while not jobs.held:
        robot.step()
    replies = []
    begin_sending(robot, joint, replies)
    robot.call("clear")
    jobs.release()
    robot.clock.advance(joint_maps.RETRY)
    robot.graph.run_due()
    assert isinstance(replies[-1], Unavailable)
    robot.step(10)
    jobs.release()
    begin_sending(robot, file_of(robot), replies)
    jobs.release()
    assert replies[-1].key_frames > 0


def test_map_of_other_robots_is_refused_and_the_own_one_stays(joint):
    robot, other = MappingRobot(first_drive()), MappingRobot(second_drive())
    for each in (robot, other):
        each.step(20)
    own = frame_ids(robot.node._mapping())
    with pytest.raises(Conflict, match="no scan of this robot's map"):
        send(robot, file_of(other))
    assert frame_ids(robot.node._mapping()) == own
    robot.step(20)
    assert len(robot.node._mapping().frames) > len(own)


def test_loops_that_waited_for_a_joint_map_are_closed_although_it_is_refused():
    jobs = HeldJobs()
    robot, other = MappingRobot(second_drive(), worker=jobs), MappingRobot(first_drive())
    for each in (robot, other):
        each.step(20)
    jobs.release()
    replies = []
    begin_sending(robot, file_of(other), replies)
    robot.step(MET)
    assert len(jobs.held) == 1
    jobs.release()
    assert isinstance(replies[-1], Conflict)
    assert len(jobs.held) == 1


@pytest.mark.parametrize(
    ("page", "error"),
    [
        (UseJointMapRequest(0, 0, ""), QuotaExceeded),
        (UseJointMapRequest(0, 1 << 40, ""), QuotaExceeded),
        (UseJointMapRequest(-1, 9, "AAAA"), InvalidInput),
        (UseJointMapRequest(3, 9, "AAAA"), InvalidInput),
        (UseJointMapRequest(0, 3, "AAAAAAAAAAAA"), InvalidInput),
        (UseJointMapRequest(0, 9, "?"), InvalidInput),
        (UseJointMapRequest(0, 9, "é"), InvalidInput),
        (UseJointMapRequest(0, 3, "AAAA"), Unavailable),
    ],
)
def test_pages_that_do_not_follow_are_refused(page, error):
    robot = MappingRobot(first_drive())
    with pytest.raises(error):
        robot.call("grid_slam/use_joint_map", page)


def test_positions_of_robots_are_cut_out_after_the_merge(met):
    robot = met.robot
    frames = robot.node._mapper.key_frames
    assert robot.node._others.are_in(frames)
    robot.graph.inject("robots", RobotStates(Header(frame_id="map"), [Pose.of(robot.in_map)], [], [0.2]))
    scan = frames.scan_points(len(frames) - 1)
    at = Pose2D(*frames.poses[-1].tolist())
    points = at @ Pose2D(*scan.points[scan.valid][0].tolist(), 0.0)
    robot.graph.inject("robots", RobotStates(Header(frame_id="map"), [Pose.of(points)], [], [0.3]))
    left = robot.node._others.cut_from(scan, at, frames, robot.clock())
    assert left.valid.sum() < scan.valid.sum()
