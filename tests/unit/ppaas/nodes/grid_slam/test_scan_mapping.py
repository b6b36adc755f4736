"""Loop closures in jobs, and robots that were carried away."""

import numpy as np
import pytest

from ppaas.change_log import LogEntry
from ppaas.errors import InvalidGraph, Unavailable
from ppaas.mapping.live import refining_work
from ppaas.mapping.live.background_work import ClosingWork
from ppaas.mapping.live.refining_work import RefiningWork
from ppaas.maps.grid import UNKNOWN
from ppaas.messages.slam_toolbox import GetPoseGraphRequest
from ppaas.nodes.grid_slam.scan_mapping import IDLE
from ppaas.nodes.key_frame_path import key_frames_of
from tests.support.world.carried_robots import carried
from tests.support.world.mapping_robot import HeldJobs, MappingRobot
from tests.support.world.ring_drive import ring_drive

DRIVEN = 150
"""Number of scans of the drive."""


def stand(robot: MappingRobot, seconds: float) -> None:
    for _ in range(round(seconds)):
        robot.clock.advance(1.0)
        robot.graph.run_due()


def drive(robot: MappingRobot, count: int = DRIVEN) -> None:
    """Drive on, with scans every 0.1 s, after the robot has stood."""
    for number in range(robot.next, robot.next + count):
        robot.clock.advance(0.1)
        robot.odom(robot.odometry(number))
        robot.graph.inject("scan", robot.scan_message(number))
        robot.graph.run_due()
    robot.next += count


@pytest.fixture
def robot() -> MappingRobot:
    robot = MappingRobot(ring_drive())
    drive(robot)
    return robot


def test_the_map_is_refined_once_while_the_robot_stands(robot):
    mapper, heard = robot.node._mapper, []
    robot.graph.tap("key_frames", lambda _, message: heard.append(key_frames_of(message)))
    before = mapper.key_frames.poses.copy()
    stand(robot, IDLE - 1)
    assert (mapper.renewals, heard) == (0, [])
    stand(robot, 2)
    assert mapper.renewals == len(heard) == 1
    assert 1e-4 < np.abs(mapper.key_frames.poses - before).max() < 0.1
    stand(robot, 3 * IDLE)
    assert mapper.renewals == 1, "nothing is new"
    assert robot.displayed().data.tolist() == robot.map().data.tolist()
    drive(robot, 100)
    assert robot.true_error() < 0.05
    stand(robot, IDLE + 1)
    assert mapper.renewals == 2


def test_another_container_has_the_refined_map(robot):
    robot.node.log_change()
    stand(robot, IDLE + 1)
    assert robot.node.has_log_change, "although there is no key frame"
    state, change = robot.node.checkpoint(), robot.node.whole_log()
    again = MappingRobot(ring_drive())
    again.node.restore(state)
    again.node.restore_log([LogEntry(*entry) for entry in change.entries])
    mapper, other = robot.node._mapper, again.node._mapper
    np.testing.assert_array_equal(other.key_frames.poses, mapper.key_frames.poses)
    assert other.pose.distance_to(mapper.pose) < 1e-9


def test_a_key_frame_cancels_the_refinement_and_the_search_follows():
    jobs = HeldJobs()
    robot = MappingRobot(ring_drive(), worker=jobs)
    drive(robot)
    while jobs.held:
        jobs.release()
    stand(robot, IDLE + 1)
    ((_, cancelled, _),) = jobs.held
    assert isinstance(robot.node._mapper._running, RefiningWork)
    poses = robot.node._mapper.key_frames.poses.copy()
    assert not cancelled()
    drive(robot, 60)
    assert cancelled()
    jobs.release()
    assert robot.node._mapper.renewals == 0
    np.testing.assert_array_equal(robot.node._mapper.key_frames.poses[: len(poses)], poses)
    assert isinstance(robot.node._mapper._running, ClosingWork)
    while jobs.held:
        jobs.release()
    stand(robot, IDLE + 1)
    jobs.release()
    assert robot.node._mapper.renewals == 1


def test_a_refinement_of_a_map_that_was_cleared_is_dropped():
    jobs = HeldJobs()
    robot = MappingRobot(ring_drive(), worker=jobs)
    drive(robot)
    while jobs.held:
        jobs.release()
    stand(robot, IDLE + 1)
    robot.call("clear")
    jobs.release()
    assert robot.node._mapper is None


def test_a_refinement_that_fails_is_tried_again_when_the_map_has_grown(robot, monkeypatch, caplog):
    def fail(*_, **__):
        raise InvalidGraph("the normal equations are not positive definite")

    mapper = robot.node._mapper
    monkeypatch.setattr(refining_work, "refine", fail)
    stand(robot, 3 * IDLE)
    assert len([record for record in caplog.records if "failed" in record.message]) == 1
    monkeypatch.undo()
    drive(robot, 60)
    stand(robot, IDLE + 1)
    assert mapper.renewals == 1


AT, ON = 160, 200
"""Scans between which the robot is carried."""

LATER = 300
"""Scan at which it maps the new part, before it recognizes a place."""


def status(robot: MappingRobot) -> str:
    latched = robot.graph.latched("grid_slam/status")
    return "" if latched is None else latched.data


def known(robot: MappingRobot) -> int:
    return int((robot.map().data != UNKNOWN).sum())


@pytest.fixture(scope="module")
def driven():
    """Return a robot that maps a new part, the number of known cells before, and the entries of its log."""
    robot, entries = MappingRobot(carried(ring_drive(), AT, ON)), {}

    def step(count: int) -> None:
        for _ in range(count):
            robot.step()
            change = robot.node.log_change()
            entries.update(change.entries if change else ())
            for number in change.obsolete if change else ():
                del entries[number]

    step(AT)
    before = known(robot)
    step(LATER - AT)
    return robot, before, entries


def test_the_robot_reports_it_and_shows_the_part_where_it_is(driven):
    robot, before, _ = driven
    assert status(robot).startswith("the robot was carried away")
    assert 0 < known(robot) < before
    assert robot.node._mapper.parts.current == 1


def test_a_map_without_its_larger_part_is_not_published(driven):
    robot, _, _ = driven
    with pytest.raises(Unavailable, match="carried away, and has not found"):
        robot.call("pose_graph", GetPoseGraphRequest(offset=0))
    numbers = robot.call("pose_graph", GetPoseGraphRequest(offset=-1))
    assert 0 < numbers.key_frames < len(robot.node._mapper.key_frames)


def test_a_replacement_recognizes_the_place_and_the_map_is_whole(driven):
    robot, before, entries = driven
    replacement = MappingRobot(robot.drive)
    replacement.node.restore(robot.node.checkpoint())
    replacement.node.restore_log([LogEntry(*entry) for entry in sorted(entries.items())])
    assert replacement.node._mapper.parts == robot.node._mapper.parts
    assert known(replacement) == pytest.approx(known(robot), rel=0.01)
    replacement.next = LATER
    replacement.step(len(robot.drive.log) - LATER)
    assert status(replacement) == ""
    assert replacement.true_error() < 0.06
    assert known(replacement) > before
    assert replacement.call("pose_graph", GetPoseGraphRequest(offset=-1)).key_frames > 0
