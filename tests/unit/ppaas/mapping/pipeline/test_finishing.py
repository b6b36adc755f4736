"""Finish of a mapping that was made while a robot drove."""

import numpy as np
import pytest

from ppaas.geometry import Pose2D
from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph
from ppaas.mapping.live.live_mapper import LiveMapper
from ppaas.mapping.parameters import SlamParameters
from ppaas.mapping.pipeline.graph_mapper import finish_mapping
from ppaas.mapping.scan_points import prepare
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.mapping.serialization.mapping_file import pack_mapping, unpack_mapping
from ppaas.planar_poses import compose, relative
from tests.support.world.ring_drive import ring_drive

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
