"""Joint maps of two robots in a ring of corridors: merged once, then extended by what each has mapped since."""

import numpy as np
import pytest

from ppaas.errors import InvalidInput, MapsNotMerged
from ppaas.mapping.graph.pose_graph import EdgeKind
from ppaas.mapping.merging.joint_map import join_maps
from ppaas.mapping.merging.united import frame_ids, united
from ppaas.mapping.serialization.mapping_file import pack_mapping, unpack_mapping
from ppaas.planar_poses import relative
from tests.support.world.mapping_parts import beginning
from tests.support.world.mappings import room_mapping
from tests.support.world.merge_drives import (
    first_drive,
    first_mapping,
    second_drive,
    second_mapping,
    true_lasers,
)

EARLY, LATE = 110, 150
"""Numbers of key frames of both robots at the merge and at the exchange after it."""


def parts(count):
    return beginning(first_mapping(), count), beginning(second_mapping(), count)


def read(mapping):
    return unpack_mapping(b"".join(pack_mapping(mapping)))


@pytest.fixture(scope="module")
def merged():
    return join_maps([[part] for part in parts(EARLY)])


@pytest.fixture(scope="module")
def continued(merged):
    """Mappings of both robots, which went on with the merged map."""
    return [united(read(merged.mapping), read(part)).mapping for part in parts(LATE)]


@pytest.fixture(scope="module")
def exchanged(continued):
    return join_maps([continued])


def true_by_id():
    true = {}
    for drive, mapping in ((first_drive(), first_mapping()), (second_drive(), second_mapping())):
        true |= dict(zip(frame_ids(mapping), true_lasers(drive, mapping), strict=True))
    return true


def errors(mapping):
    """Return the errors of relative poses of key frames less than 3 m apart [m]."""
    by_id = true_by_id()
    true = np.array([by_id[each] for each in frame_ids(mapping)])[::4]
    poses = mapping.frames.poses[::4]
    off = relative(relative(true[:, None], true[None]), relative(poses[:, None], poses[None]))
    near = np.hypot(*(true[:, None] - true[None])[..., :2].transpose(2, 0, 1)) < 3.0
    return np.hypot(off[..., 0], off[..., 1])[near]


def test_robots_without_a_common_start_are_merged_by_places(merged):
    assert merged.places >= 3
    assert len(merged.mapping.frames) == 2 * EARLY
    assert errors(merged.mapping).mean() < 0.02


def test_what_both_mapped_since_is_in_the_joint_map_once(exchanged):
    ids = frame_ids(exchanged.mapping)
    assert exchanged.places == 0
    assert len(set(ids)) == len(ids) == 2 * LATE
    assert set(ids) == {each for part in parts(LATE) for each in frame_ids(part)}


def test_joint_map_stays_in_the_frame_of_the_first_robot(merged, exchanged):
    start = first_mapping().frames.poses[0]
    np.testing.assert_array_equal(merged.mapping.frames.poses[0], start)
    np.testing.assert_array_equal(exchanged.mapping.frames.poses[0], start)


def test_loops_between_the_new_parts_are_closed(exchanged, continued):
    edges = exchanged.mapping.graph.edges
    known = continued[0].graph.edges
    assert (edges.kinds == EdgeKind.CLOSURE).sum() > (known.kinds == EdgeKind.CLOSURE).sum()
    assert errors(exchanged.mapping).mean() < 0.02
    assert errors(exchanged.mapping).max() < 0.2


def test_robot_that_did_not_hear_of_the_merge_joins_without_a_search(merged):
    late = parts(LATE)[1]
    joint = join_maps([[merged.mapping], [late]])
    assert joint.places == 0
    assert len(joint.mapping.frames) == EARLY + LATE


def test_map_of_robots_is_read_again_as_it_was_written(exchanged):
    np.testing.assert_array_equal(read(exchanged.mapping).frames.poses, exchanged.mapping.frames.poses)


def test_robot_that_began_another_map_does_not_belong_to_the_group(merged):
    other = beginning(second_mapping(), 30)
    other.frames.points[:] += 0.2
    with pytest.raises(MapsNotMerged, match="no scan in common"):
        join_maps([[merged.mapping, other]])


def test_lasers_have_to_be_the_same():
    with pytest.raises(InvalidInput, match="the lasers differ"):
        join_maps([[first_mapping()], [room_mapping(3)]])
