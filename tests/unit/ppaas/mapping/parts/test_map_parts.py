from itertools import pairwise

import numpy as np
import pytest

from ppaas.errors import Unavailable
from ppaas.mapping.closures.submaps import Submap
from ppaas.mapping.graph.pose_graph import components
from ppaas.mapping.graph.solver import GraphSolver
from ppaas.mapping.parts.joining import LEAST_TRAVEL, JoiningSchedule, join, placed_beside
from ppaas.mapping.parts.map_parts import WHOLE, MapParts, check_is_main, current_part, extract
from ppaas.mapping.serialization.mapping import Mapping
from tests.support.world.mappings import room_mapping

THREE = WHOLE.begin(4).begin(7)
"""Key frames 0 to 3, 4 to 6, and from 7 on."""


def divided(mapping: Mapping, parts: MapParts) -> Mapping:
    """Return a mapping without the edges between its parts."""
    edges = mapping.graph.edges
    numbers = np.zeros(len(mapping.frames), np.int64)
    for number in (parts.current, *parts.others):
        numbers[parts.indices(number, len(numbers))] = number
    graph = mapping.graph.copy()
    graph.keep_edges(numbers[edges.first] == numbers[edges.second])
    return Mapping(mapping.frames, graph, mapping.laser_frame)


def test_a_new_part_is_the_current_one_and_grows():
    assert (THREE.current, THREE.others, THREE.is_whole, THREE.last_start) == (2, [0, 1], False, 7)
    assert THREE.indices(2, 10).tolist() == [7, 8, 9]
    assert THREE.indices(0, 10).tolist() == [0, 1, 2, 3]
    assert THREE.runs(2, 7) == []


def test_parts_that_join_have_one_number():
    joined = THREE.join(0, 2)
    assert joined.indices(0, 9).tolist() == [0, 1, 2, 3, 7, 8]
    assert (joined.current, joined.others) == (0, [1])
    assert joined.join(0, 1) == WHOLE
    assert THREE.join(1, 2) == MapParts((0, 4), (0, 1))


def test_parts_are_read_off_a_graph():
    mapping = divided(room_mapping(9), THREE)
    assert MapParts.of(mapping.graph) == THREE
    mapping.graph.add_edge(1, 8, np.zeros(3), np.eye(3), 1)
    assert MapParts.of(mapping.graph) == THREE.join(0, 2)
    assert MapParts.of(room_mapping(3).graph) == WHOLE


def test_submaps_are_searched_within_their_run():
    submaps = [Submap(0, 2), Submap(2, 4), Submap(4, 7), Submap(7, 9)]
    assert THREE.beside(submaps[:2]) == submaps[:2]
    assert THREE.beside(submaps) == [Submap(7, 9)]
    assert THREE.by_run(submaps) == [submaps[:2], [Submap(4, 7)], [Submap(7, 9)]]
    assert WHOLE.beside(submaps) == submaps


def test_a_solve_leaves_parts_where_they_are():
    mapping = divided(room_mapping(9), THREE)
    held = THREE.held(mapping.graph)
    assert components(held).max() == 0
    np.testing.assert_allclose(GraphSolver().solve(held).poses, mapping.graph.poses, atol=1e-9)
    assert mapping.graph.edge_count == held.edge_count - 2


def test_the_mapping_of_a_part_has_its_key_frames_and_edges():
    mapping = divided(room_mapping(9), THREE)
    part = extract(mapping, THREE.indices(2, 9))
    assert (len(part.frames), part.graph.edge_count, part.laser_frame) == (2, 1, "laser")
    np.testing.assert_array_equal(part.frames.points, mapping.frames.points[7:])
    np.testing.assert_array_equal(part.graph.poses, mapping.graph.poses[7:])


def test_the_current_part_is_the_main_one_unless_another_one_is_larger():
    with pytest.raises(Unavailable, match="carried away, and has not found the 4 key frames"):
        check_is_main(THREE, 9)
    check_is_main(THREE, 11)
    check_is_main(WHOLE, 1)
    mapping = divided(room_mapping(9), THREE)
    assert len(current_part(mapping, THREE).frames) == 2
    assert current_part(mapping, WHOLE) is mapping


def straight(length: float) -> np.ndarray:
    """Return poses of key frames every 0.5 m along x."""
    x = np.arange(0.0, length + 0.25, 0.5)
    return np.column_stack((x, np.zeros((len(x), 2))))


def test_a_part_is_compared_when_it_has_grown_enough_and_again_when_it_has_grown_further():
    schedule, parts = JoiningSchedule(), WHOLE.begin(2)
    due = [at for at in np.arange(1.0, 60.0, 0.5) if schedule.is_due(parts, straight(at + 1.0))]
    assert due[0] == LEAST_TRAVEL
    assert np.all(np.diff(due) >= 6.0)
    assert np.diff(due)[-1] > 6.0
    assert not schedule.is_due(parts.begin(100), straight(60.0))
    assert not schedule.is_due(WHOLE, straight(60.0))


def test_a_comparison_can_be_cancelled():
    asked = []
    mapping = room_mapping(30)
    assert join(mapping, WHOLE.begin(10), lambda: asked.append(1) or True) is None
    assert len(asked) < 5


def test_parts_that_do_not_overlap_enough_are_left_apart():
    assert join(room_mapping(30), WHOLE.begin(15), lambda: False) is None


def test_parts_lie_beside_each_other():
    mapping, parts = room_mapping(12), WHOLE.begin(4).begin(8)
    poses = placed_beside(Mapping(mapping.frames, mapping.graph), parts, 2.0)
    np.testing.assert_array_equal(poses[:4], mapping.graph.poses[:4])
    np.testing.assert_allclose(poses[:, 1:], mapping.graph.poses[:, 1:], atol=1e-12)
    seen = [_seen(mapping, poses, parts.indices(number, 12)) for number in range(3)]
    gaps = [after[0] - before[1] for before, after in pairwise(seen)]
    np.testing.assert_allclose(gaps, 2.0, atol=1e-6)


def _seen(mapping: Mapping, poses: np.ndarray, chosen: np.ndarray) -> tuple[float, float]:
    xs = np.concatenate([
        poses[k, 0] + np.cos(poses[k, 2]) * mapping.frames.points[k, :, 0][mapping.frames.valid[k]]
        - np.sin(poses[k, 2]) * mapping.frames.points[k, :, 1][mapping.frames.valid[k]]
        for k in chosen
    ])  # fmt: skip
    return float(xs.min()), float(xs.max())
