"""Refinement by ``grid_slam``: it is done while the robot stands, and a key frame cancels it."""

import numpy as np
import pytest

from ppaas.change_log import LogEntry
from ppaas.errors import InvalidGraph
from ppaas.mapping.live import refining_work
from ppaas.mapping.live.closing_work import ClosingWork
from ppaas.mapping.live.refining_work import RefiningWork
from ppaas.nodes.grid_slam.scan_mapping import IDLE
from ppaas.nodes.key_frame_path import key_frames_of
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
