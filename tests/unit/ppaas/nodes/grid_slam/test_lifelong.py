"""Lifelong mapping by ``grid_slam``: a robot goes round a room again and again, and a box is moved."""

from functools import cache

import numpy as np
import pytest

from benchmarks.mapping.simulated_drive import SimulatedDrive
from benchmarks.mapping.small_worlds import AFTER, BEFORE, changing_drive, room
from ppaas.change_log import LogEntry
from ppaas.geometry import Pose2D
from ppaas.mapping.live.live_mapper import LiveMapper
from ppaas.maps.grid import OCCUPIED, GridMap
from ppaas.nodes.grid_slam.logbook import Head, resume
from tests.support.world.mapping_robot import MappingRobot

LAPS, CHANGE = 7, 2
"""Laps of the drive, and the lap before which the box is moved."""


@cache
def drive() -> SimulatedDrive:
    return changing_drive([room(BEFORE)] * CHANGE + [room(AFTER)] * (LAPS - CHANGE), beams=60)


class Stored:
    """Checkpoint and log of a robot, as they are stored together."""

    def __init__(self):
        self.state, self.entries, self.largest = b"", {}, 0

    def save(self, robot):
        change = robot.node.log_change()
        self.state = robot.node.checkpoint()
        if change is not None:
            self.entries |= dict(change.entries)
            for number in change.obsolete:
                del self.entries[number]
        self.largest = max(self.largest, sum(map(len, self.entries.values())))

    def restored(self):
        robot = MappingRobot(drive(), mode="lifelong")
        robot.node.restore(self.state)
        robot.node.restore_log([LogEntry(*entry) for entry in sorted(self.entries.items())])
        return robot


def at_box(grid: GridMap, box: tuple[float, float, float, float]) -> int:
    """Return the number of occupied cells at a box, away from the walls."""
    origin, info = drive().true[0, :2], grid.info
    rows, columns = np.nonzero(grid.data == OCCUPIED)
    x = (columns + 0.5) * info.resolution + info.origin.x + origin[0]
    y = (rows + 0.5) * info.resolution + info.origin.y + origin[1]
    inside = (x > max(box[0], 0.2) - 0.1) & (x < box[2] + 0.1) & (y > max(box[1], 0.2) - 0.1) & (y < box[3] + 0.1)
    return int(inside.sum())


@pytest.fixture(scope="module")
def driven():
    """Return a robot after the drive, what was stored of it, and the numbers of its key frames after each lap."""
    robot, stored, counts = MappingRobot(drive(), mode="lifelong"), Stored(), []
    for lap in range(LAPS):
        while robot.next < len(drive().log) * (lap + 1) // LAPS:
            robot.step(10 if robot.next + 10 < len(drive().log) else 1)
            if robot.node.has_log_change:
                stored.save(robot)
        counts.append(len(robot.node._mapper.key_frames))
        if lap == CHANGE - 1:
            assert at_box(robot.map(), BEFORE) > 20
    return robot, stored, counts


def test_the_number_of_key_frames_stays(driven):
    counts = driven[2]
    assert max(counts[4:]) <= 5 * counts[0]
    assert counts[-1] <= counts[4] + 10


def test_what_moved_is_at_its_new_place(driven):
    robot = driven[0]
    for grid in (robot.map(), robot.displayed()):
        assert at_box(grid, BEFORE) == 0
        assert at_box(grid, AFTER) > 8
    assert robot.true_error() < 0.05


def test_another_container_goes_on_with_the_thinned_map(driven):
    robot, stored, _ = driven
    stored.save(robot)
    assert len(stored.entries) < 150
    assert stored.largest < 400_000
    again = stored.restored()
    np.testing.assert_array_equal(again.node._mapper.key_frames.scans, robot.node._mapper.key_frames.scans)
    np.testing.assert_allclose(again.node._mapper.pose, robot.node._mapper.pose, atol=1e-3)
    assert again.node._mapper.searched == robot.node._mapper.searched
    assert at_box(again.map(), BEFORE) == 0


def test_a_checkpoint_from_before_a_thinning_names_its_key_frame_by_the_scan(driven):
    mapper = driven[0].node._mapper
    mapping, pose = mapper.mapping("laser"), mapper.pose
    scan = int(mapping.frames.scans[5])
    for head, expected in (
        (Head(40, (0.1, 0.0, 0.0), (0.0, 0.0, 0.0), 3, scan=scan), mapping.frames.poses[5]),
        (Head(5, (0.1, 0.0, 0.0), (0.0, 0.0, 0.0), 3), mapping.frames.poses[5]),
    ):
        again = LiveMapper(mapping.frames.geometry)
        resume(again, mapping, head)
        np.testing.assert_allclose(again.pose, Pose2D(*expected) @ Pose2D(0.1, 0.0, 0.0))
    removed = min(set(range(scan)) - set(mapping.frames.scans.tolist()))
    again = LiveMapper(mapping.frames.geometry)
    resume(again, mapping, Head(5, (9.0, 0.0, 0.0), (0.0, 0.0, 0.0), 3, scan=removed))
    assert again.pose.distance_to(pose) < 0.5


def test_parameters_of_slam_toolbox_without_effect_are_reported(caplog):
    caplog.set_level("INFO")
    MappingRobot(drive(), mode="lifelong", lifelong_minimum_score=0.1, lifelong_search_use_tree=False)
    assert "'lifelong_minimum_score' of grid_slam has no effect" in caplog.text
    assert "'lifelong_search_use_tree' of grid_slam has no effect" in caplog.text
