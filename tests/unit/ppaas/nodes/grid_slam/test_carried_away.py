"""Node ``grid_slam`` of a robot that is carried away while it maps."""

import pytest

from ppaas.change_log import LogEntry
from ppaas.errors import Unavailable
from ppaas.maps.grid import UNKNOWN
from ppaas.messages.slam_toolbox import GetPoseGraphRequest
from tests.support.world.carried_robots import carried
from tests.support.world.mapping_robot import MappingRobot
from tests.support.world.ring_drive import ring_drive

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
