"""Merges of mappings of a ring of corridors by two robots, with known true poses."""

import numpy as np
import pytest

from benchmarks.mapping.simulated_drive import simulate
from ppaas.errors import InvalidInput, MapsNotMerged
from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph, balance
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.merging import merge as merging
from ppaas.mapping.merging.merge import merge
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.mapping.serialization.mapping_file import pack_mapping, unpack_mapping
from ppaas.planar_poses import compose, relative
from tests.support.world.merge_drives import (
    first_drive,
    first_mapping,
    mapping_of,
    second_drive,
    second_mapping,
    true_lasers,
)
from tests.support.world.room_scans import ROOM


@pytest.fixture(scope="module")
def parts():
    return first_mapping(), second_mapping()


@pytest.fixture(scope="module")
def merged(parts):
    return merge(*parts)


def cross_errors(merged, first, second):
    """Return the errors of the poses of the second mapping's key frames in those of the first [m]."""
    true = np.concatenate((true_lasers(first_drive(), first), true_lasers(second_drive(), second)))
    poses, count = merged.mapping.frames.poses, len(first.frames)
    rows, columns = np.arange(0, count, 5)[:, None], np.arange(count, len(poses), 5)[None, :]
    error = relative(relative(true[rows], true[columns]), relative(poses[rows], poses[columns]))
    near = np.hypot(*(true[rows] - true[columns])[..., :2].transpose(2, 0, 1)) < 3.0
    return np.hypot(error[..., 0], error[..., 1])[near]


def test_scans_of_two_robots_are_placed_to_centimetres(merged, parts):
    errors = cross_errors(merged, *parts)
    assert errors.mean() < 0.01
    assert errors.max() < 0.05


def test_result_is_in_the_frame_of_the_first_mapping(merged, parts):
    first, second = parts
    np.testing.assert_array_equal(merged.mapping.frames.poses[0], first.frames.poses[0])
    assert len(merged.mapping.frames) == merged.mapping.graph.node_count == len(first.frames) + len(second.frames)
    np.testing.assert_allclose(
        merged.mapping.frames.poses[len(first.frames)], compose(np.array(merged.motion), second.graph.poses[0])
    )
    np.testing.assert_array_equal(merged.mapping.frames.poses, merged.mapping.graph.poses)


def test_numbers_of_scans_go_on(merged, parts):
    numbers = merged.mapping.frames.scans
    assert (np.diff(numbers) > 0).all()
    assert numbers[len(parts[0].frames)] == parts[0].frames.scans[-1] + 1


def test_edges_between_the_mappings_are_closures(merged, parts):
    edges, count = merged.mapping.graph.edges, len(parts[0].frames)
    across = (edges.first < count) & (edges.second >= count)
    assert across.sum() >= 10
    assert (edges.kinds[across] == EdgeKind.CLOSURE).all()


def test_inputs_stay_unchanged(parts):
    first, second = parts
    before = first.graph.poses.copy(), second.graph.poses.copy(), second.frames.poses.copy()
    merge(first, second)
    for kept, found in zip(before, (first.graph.poses, second.graph.poses, second.frames.poses), strict=True):
        np.testing.assert_array_equal(kept, found)


def test_a_merge_survives_its_file(merged):
    read = unpack_mapping(b"".join(pack_mapping(merged.mapping)))
    np.testing.assert_array_equal(read.frames.poses, merged.mapping.frames.poses)
    assert read.graph.edge_count == merged.mapping.graph.edge_count


def test_mappings_of_different_lasers_become_one(parts):
    first, finer = parts[0], second_mapping(135)
    merged = merge(first, finer)
    frames, count = merged.mapping.frames, len(first.frames)
    assert cross_errors(merged, first, finer).mean() < 0.015
    assert frames.geometry.beams == 135
    # No reading of either laser is lost, up to points that the motion of the laser moved to the same beam.
    assert frames.valid[:count].sum() >= 0.99 * first.frames.valid.sum()
    assert frames.valid[count:].sum() >= 0.99 * finer.frames.valid.sum()


def test_progress_ascends_to_its_end(parts):
    heard = []
    merge(*parts, done=lambda done, of: heard.append((done, of)))
    assert heard == sorted(heard)
    assert {of for _, of in heard} == {heard[-1][0]}


def test_a_merge_ends_when_its_progress_raises(parts):
    def stop(_done, _of):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        merge(*parts, done=stop)


def test_different_buildings_are_refused(parts):
    room = np.array([(-3.0, -2.0), (3.0, -2.0), (3.0, 2.3), (-3.0, 2.3), (-3.0, -2.0)])
    other = mapping_of(simulate(ROOM, room, 3, beams=90))
    for pair in ((parts[0], other), (other, parts[0])):
        with pytest.raises(MapsNotMerged, match=r"too few places|contradicted"):
            merge(*pair)


def test_a_mapping_that_is_too_short_is_refused(parts):
    short = mapping_of(second_drive().first(60))
    with pytest.raises(MapsNotMerged, match="too few places"):
        merge(parts[0], short)


def test_a_mapping_without_scans_is_refused(parts):
    empty = Mapping(KeyFrames(parts[0].frames.geometry), PoseGraph())
    with pytest.raises(InvalidInput, match="without scans"):
        merge(parts[0], empty)


def test_maps_that_were_refined_are_aligned_with_the_measured_odometry_alone(parts, monkeypatch):
    first, second = parts
    graph, aligned = first.graph.copy(), []
    balance(graph, first.frames.poses)
    refine = merging.refine
    monkeypatch.setattr(merging, "refine", lambda *args: aligned.append(args[2]) or refine(*args))
    merge(Mapping(first.frames, graph, first.laser_frame), second)
    measured = [(mapping.graph.edges.kinds == EdgeKind.ODOMETRY).sum() for mapping in parts]
    assert [len(odometry.first) for odometry in aligned] == [sum(measured)]
