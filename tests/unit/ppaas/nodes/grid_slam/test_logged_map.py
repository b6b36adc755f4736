"""A map that moves with its node to another executor, and back."""

import numpy as np

from ppaas.change_log import LogChange, LogEntry
from tests.support.world.mapping_robot import MappingRobot
from tests.support.world.ring_drive import ring_drive

STEPS = 30


def applied(log: dict[int, bytes], change: LogChange | None) -> dict[int, bytes]:
    """Return a stored log after a change."""
    if change is None:
        return log
    return {number: data for number, data in (log | dict(change.entries)).items() if number not in change.obsolete}


def moved(robot, log):
    """Return a robot whose node continues the map of another's."""
    another = MappingRobot(ring_drive())
    state = robot.node.checkpoint()
    another.node.restore(state)
    another.node.restore_log([LogEntry(*entry) for entry in sorted(log.items())])
    another.next = robot.next
    return another


def test_the_map_moves_with_its_node_and_the_stored_log_follows():
    robot = MappingRobot(ring_drive())
    robot.step(STEPS)
    stored = applied({}, robot.node.log_change())
    robot.step(STEPS)
    for _ in range(2):  # to the robot, and back to the cloud
        before = set(stored)
        stored = applied(stored, robot.node.whole_log())
        assert not before & set(stored), "entries have new numbers, so that no change of before applies to them"
        frames = len(robot.node._mapper.key_frames)
        robot = moved(robot, stored)
        assert len(robot.node._mapper.key_frames) == frames
        robot.step(STEPS)
        stored = applied(stored, robot.node.log_change())
    assert robot.true_error() < 0.05
    last = moved(robot, stored)
    np.testing.assert_array_equal(last.node._mapper.key_frames.poses, robot.node._mapper.key_frames.poses)


def test_a_node_without_a_map_has_no_log_to_move():
    assert MappingRobot(ring_drive()).node.whole_log() is None
