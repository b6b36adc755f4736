"""United mappings: key frames are the same wherever they are, and are never there twice."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.mapping.merging.united import frame_ids, frame_name, united
from ppaas.mapping.serialization.mapping_file import pack_mapping, unpack_mapping
from ppaas.planar_poses import compose, relative
from tests.support.budget import examples
from tests.support.world.mapping_parts import beginning
from tests.support.world.mappings import room_mapping

MOTION = np.array((3.0, -2.0, 0.7))


@pytest.fixture(scope="module")
def tour():
    return room_mapping(60, closures=15)


def read(mapping):
    return unpack_mapping(b"".join(pack_mapping(mapping)))


def moved(mapping):
    """Return a mapping in another frame."""
    copied = read(mapping)
    copied.frames.poses[:] = compose(MOTION, copied.frames.poses)
    copied.graph.move_nodes(copied.frames.poses)
    return copied


def test_ids_of_key_frames_are_those_of_the_file_that_is_read_again(tour):
    ids = frame_ids(tour)
    assert len(set(ids)) == len(tour.frames)
    assert frame_ids(read(tour)) == ids
    assert frame_ids(moved(tour)) == ids


def test_mappings_without_a_common_key_frame_are_not_united(tour):
    other = room_mapping(70)
    other.frames.points[:] += 0.1
    assert united(tour, other) is None


@settings(deadline=None, max_examples=examples(15))
@given(first=st.integers(1, 60), second=st.integers(1, 60))
def test_two_parts_of_one_drive_are_the_longer_part(tour, first, second):
    both = united(beginning(tour, first), moved(beginning(tour, second)))
    whole = beginning(tour, max(first, second))
    np.testing.assert_array_equal(both.places, np.arange(second))
    np.testing.assert_allclose(both.mapping.frames.poses, whole.frames.poses, atol=1e-12)
    np.testing.assert_array_equal(both.mapping.graph.poses, both.mapping.frames.poses)
    assert both.mapping.graph.edge_count == whole.graph.edge_count
    assert (np.diff(both.mapping.frames.scans) > 0).all()
    assert len(read(both.mapping).frames) == max(first, second)


def test_new_key_frames_hang_on_the_one_before_them_that_both_have(tour):
    first, second = beginning(tour, 40), moved(tour)
    first.frames.poses[39] += (0.5, 0.0, 0.0)
    first.graph.move_nodes(first.frames.poses)
    poses = united(first, second).mapping.frames.poses
    true = tour.graph.poses
    np.testing.assert_allclose(relative(poses[39], poses[40:]), relative(true[39], true[40:]), atol=1e-12)


def test_tails_of_two_robots_with_a_common_part_are_both_kept(tour):
    common, other = beginning(tour, 30), room_mapping(90)
    ids = frame_ids(common)
    tail = united(common, other).mapping  # the same walk without closures
    first = united(tail, tour).mapping
    assert frame_ids(first)[:30] == ids
    assert len(first.frames) == 90
    assert first.graph.edge_count == 89 + 15


def test_inputs_stay_unchanged(tour):
    first, second = beginning(tour, 20), moved(tour)
    before = first.frames.poses.copy(), second.frames.poses.copy(), second.graph.edge_count
    united(first, second)
    np.testing.assert_array_equal(first.frames.poses, before[0])
    np.testing.assert_array_equal(second.frames.poses, before[1])
    assert second.graph.edge_count == before[2]


def test_frame_is_named_by_the_first_key_frame_and_its_pose(tour):
    name = frame_name(tour.frames)
    assert name == frame_name(beginning(read(tour), 5).frames)
    assert name != frame_name(moved(tour).frames)
    other = beginning(tour, 1)
    other.frames.points[0] += 0.1
    assert name != frame_name(other.frames)
