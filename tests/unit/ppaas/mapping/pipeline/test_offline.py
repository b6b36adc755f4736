"""Offline mapping of a simulated drive with true poses, and the finish of a mapping made while a robot drove."""

import math
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.mapping.map_errors import absolute_errors, random_relations
from benchmarks.mapping.simulated_drive import simulate
from benchmarks.mapping.small_worlds import LAP, walls
from ppaas.geometry import Pose2D
from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph
from ppaas.mapping.live.live_mapper import LiveMapper
from ppaas.mapping.parameters import SlamParameters
from ppaas.mapping.pipeline.graph_mapper import finish_mapping
from ppaas.mapping.pipeline.offline import LogMap, map_log
from ppaas.mapping.relations import score
from ppaas.mapping.scan_points import prepare
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.mapping.serialization.mapping_file import pack_mapping, unpack_mapping
from ppaas.maps.grid import FREE, OCCUPIED
from ppaas.planar_poses import compose, relative
from tests.support.world.ring_drive import ring_drive


@pytest.fixture(scope="module")
def made() -> LogMap:
    return map_log(ring_drive().log)


def test_poses_are_within_a_centimetre_of_the_truth(made):
    drive = ring_drive()
    assert absolute_errors(drive.true, drive.log.odometry).max() > 0.3
    assert absolute_errors(drive.true, made.poses).max() < 0.03
    relations = random_relations(drive.log.stamps, drive.true, 1, most=300)
    found = score(relations, drive.log.stamps, made.poses)
    assert found.translations.mean() < 0.01
    assert np.degrees(found.rotations).mean() < 0.1


def test_each_stage_improves_the_poses(made):
    true = ring_drive().true
    errors = [absolute_errors(true, poses).mean() for poses in made.stages.values()]
    assert list(made.stages) == ["tracking", "closures", "refinement", "polish"]
    assert errors[-1] <= errors[1] < errors[0]


def test_the_first_pose_is_that_of_the_odometry(made):
    np.testing.assert_allclose(made.stages["closures"][0], ring_drive().log.odometry[0], atol=1e-9)


def test_loops_are_closed_and_counted(made):
    summary = made.summary()
    assert summary["scans"] == len(ring_drive().log)
    assert 50 < summary["key_frames"] < summary["scans"]
    assert summary["closures"] > 3
    assert summary["distrusted_edges"] == 0
    assert set(summary["seconds"]) == {"tracking", "closures", "solver", "points", "refinement", "polish"}


def test_the_map_shows_the_ring(made):
    grid = made.grid(0.05)
    true, poses = ring_drive().true, made.poses
    # Walls are 0.05 m cells at the true place, moved by the first pose: the odometry starts at the origin.
    c, s = math.cos(-true[0, 2]), math.sin(-true[0, 2])
    for wall, expected in (((6.0, 0.0), OCCUPIED), ((12.0, 6.0), OCCUPIED), ((6.0, 1.2), FREE), ((1.2, 6.0), FREE)):
        x, y = np.array(wall) - true[0, :2]
        at = poses[0, :2] + (c * x - s * y, s * x + c * y)
        column, row = np.floor((at - grid.info.origin[:2]) / 0.05).astype(int)
        around = grid.data[row - 1 : row + 2, column - 1 : column + 2]
        assert (around == expected).any(), wall


def test_progress_counts_every_scan():
    counts = []
    map_log(ring_drive().log.first(20), done=counts.append)
    assert counts == list(range(1, 21))


def test_a_log_of_one_scan_has_a_map():
    made = map_log(ring_drive().log.first(1))
    assert made.poses.shape == (1, 3)
    assert (made.grid().data == OCCUPIED).any()


def test_scans_without_readings_keep_the_odometry():
    log = ring_drive().log.first(30)
    blind = replace(log, ranges=np.full_like(log.ranges, np.nan))
    made = map_log(blind)
    np.testing.assert_allclose(made.poses, log.odometry, atol=1e-6)


def test_scans_of_a_slow_laser_are_corrected_by_the_poses_found():
    """The odometry, by which they are corrected at first, is wrong by 2 % and by 15 % of the turns."""
    drive = simulate(walls(), np.array([*LAP, LAP[0]]), 4, sweep=0.15, beams=90)
    made = map_log(drive.log)
    before, after = (absolute_errors(drive.true, made.stages[stage]) for stage in ("closures", "polish"))
    assert after.mean() < 0.5 * before.mean()
    assert after.mean() < 0.01


DRIFT = 0.002
"""Error of the turn between two key frames [rad]."""


@pytest.fixture(scope="module")
def file() -> bytes:
    """Return the pose graph of a drive in which no loop was closed, and each turn measured a bit too large."""
    log = ring_drive().log
    mapper = LiveMapper(log.geometry, closures=None)
    for number, odometry in enumerate(log.odometry.tolist()):
        scan = prepare(log.ranges[number], log.geometry, SlamParameters(), np.zeros(3))
        mapper.add(scan, Pose2D(*odometry))
    mapping = mapper.mapping("laser")
    edges = mapping.graph.edges
    edges = edges._replace(measurements=edges.measurements + np.array((0.0, 0.0, DRIFT)))
    poses = [mapping.frames.poses[0]]
    for step in edges.measurements:
        poses.append(compose(poses[-1], step))
    mapping.frames.poses[:] = poses
    graph = PoseGraph.of(np.array(poses), edges)
    return b"".join(pack_mapping(Mapping(mapping.frames, graph, "laser")))


def error(mapping):
    """Return the mean distance of key frames from the true poses, seen from the first one [m]."""
    true, mount = ring_drive().true[mapping.frames.scans], np.array(ring_drive().log.geometry.mount)
    true = compose(true, mount)
    apart = relative(mapping.frames.poses[0], mapping.frames.poses) - relative(true[0], true)
    return float(np.hypot(apart[:, 0], apart[:, 1]).mean())


def test_loops_that_were_missing_are_closed(file):
    before, reported = unpack_mapping(file), []
    first = before.frames.poses[0].copy()
    after = finish_mapping(unpack_mapping(file), done=lambda part, done: reported.append((part, done)))
    assert error(before) > 0.5
    assert error(after) < 0.03
    assert (after.graph.edges.kinds == EdgeKind.CLOSURE).sum() > 3
    np.testing.assert_array_equal(after.frames.poses[0], first)
    np.testing.assert_array_equal(after.graph.poses, after.frames.poses)
    assert after.laser_frame == "laser"
    assert reported[0] == ("loops", 0.0)
    assert reported[-1] == ("alignment", 0.0)
    assert reported == sorted(reported, key=lambda report: (report[0] == "alignment", report[1]))


def test_no_loops_are_closed_where_they_are_switched_off(file):
    after = finish_mapping(unpack_mapping(file), None)
    assert not (after.graph.edges.kinds == EdgeKind.CLOSURE).any()
    assert error(after) > 0.1


def test_a_mapping_that_is_finished_again_stays_as_it_is(file):
    once = finish_mapping(unpack_mapping(file))
    again = finish_mapping(unpack_mapping(b"".join(pack_mapping(once))))
    np.testing.assert_allclose(again.frames.poses, once.frames.poses, atol=0.01)
