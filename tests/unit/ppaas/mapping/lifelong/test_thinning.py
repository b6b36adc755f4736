"""Thinning of a mapping of a room that a robot goes round again and again."""

import numpy as np
import pytest

from ppaas.errors import QuotaExceeded
from ppaas.geometry import Pose2D
from ppaas.mapping.closures.closure import Closure
from ppaas.mapping.closures.submaps import Submap
from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.lifelong import thinning
from ppaas.mapping.lifelong.parameters import LifelongParameters
from ppaas.mapping.lifelong.thinning import Chosen, is_due, renumbered_closures, thin
from ppaas.mapping.map_drawing import draw_map
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.mapping.serialization.mapping_file import pack_mapping, unpack_mapping
from ppaas.planar_poses import relative
from tests.support.world.changing_rounds import CHAIR, LAP, LASER, PARAMETERS, TABLE, go_round, mapped, with_boxes
from tests.support.world.room_scans import ROOM


def occupied(frames: KeyFrames, place: tuple[float, float]) -> int:
    """Return the number of occupied cells at a box."""
    grid = draw_map(frames, frames.poses)
    column = int((place[0] - 0.1 - grid.info.origin.x) / grid.info.resolution)
    row = int((place[1] - 0.1 - grid.info.origin.y) / grid.info.resolution)
    return int((grid.data[row : row + 12, column : column + 12] == 100).sum())


@pytest.fixture(scope="module")
def long_drive() -> tuple[KeyFrames, PoseGraph]:
    return mapped(*[with_boxes(CHAIR)] * 8)


def test_the_number_of_key_frames_does_not_grow_with_time(long_drive):
    frames, graph = long_drive
    assert len(frames) <= 4 * LAP
    assert graph.node_count == len(frames)
    assert graph.edge_count <= 3 * len(frames)


def test_the_first_lap_and_the_last_two_are_kept(long_drive):
    numbers = long_drive[0].scans
    assert np.isin(np.arange(LAP - 5), numbers).all()  # the end of a lap is where the next one begins
    assert np.isin(np.arange(6 * LAP + 5, 8 * LAP), numbers).all()


def test_a_thinned_mapping_is_whole(long_drive):
    mapping = Mapping(*long_drive, "laser")
    read = unpack_mapping(b"".join(pack_mapping(mapping)))
    assert len(read.frames) == len(mapping.frames)
    edges = mapping.graph.edges
    poses = mapping.frames.poses
    off = relative(edges.measurements, relative(poses[edges.first], poses[edges.second]))
    np.testing.assert_allclose(off, 0.0, atol=1e-6)


def test_what_moved_leaves_the_map_after_two_passes_and_what_is_new_enters():
    before, after = with_boxes(CHAIR), with_boxes(TABLE)
    once = mapped(before, before, after)[0]
    assert occupied(once, CHAIR) > 5
    twice = mapped(before, before, after, after)[0]
    assert occupied(twice, CHAIR) == 0
    assert occupied(twice, TABLE) > 5


def test_people_who_walk_through_are_not_changes():
    laps = []
    for lap in range(6):
        angle = 2.2 * lap
        laps.append(with_boxes(CHAIR, (2.4 * np.cos(angle) - 0.2, 2.0 * np.sin(angle) - 0.2)))
    frames, _ = mapped(with_boxes(CHAIR), *laps, with_boxes(CHAIR), with_boxes(CHAIR))
    assert occupied(frames, CHAIR) > 5
    for lap in range(6):
        place = 2.4 * np.cos(2.2 * lap) - 0.2, 2.0 * np.sin(2.2 * lap) - 0.2
        near_chair = np.hypot(place[0] - CHAIR[0], place[1] - CHAIR[1]) < 0.8
        assert near_chair or occupied(frames, place) <= 2


def test_protected_and_first_key_frames_stay():
    frames, graph = KeyFrames(LASER), PoseGraph()
    for _ in range(5):
        go_round(frames, graph, with_boxes(CHAIR))
    free = thin(frames, graph, Chosen(0, np.zeros(len(frames), np.bool_)), PARAMETERS)
    assert free.kept[0] and not free.kept.all()
    fixed = thin(frames, graph, Chosen(0, np.ones(len(frames), np.bool_)), PARAMETERS)
    assert fixed.kept.all()
    assert thin(frames, graph, Chosen(0, fixed.kept), PARAMETERS, cancelled=lambda: True) is None


def test_a_map_that_is_too_large_for_an_entry_of_a_log_is_not_thinned(monkeypatch):
    frames, graph = KeyFrames(LASER), PoseGraph()
    for _ in range(4):
        go_round(frames, graph, ROOM)
    monkeypatch.setattr(thinning, "MOST_BYTES", 1 << 10)
    with pytest.raises(QuotaExceeded, match="is not thinned, at most 0 MiB are: map with fewer beams"):
        thin(frames, graph, Chosen(0, np.zeros(len(frames), np.bool_)), PARAMETERS)


def test_what_came_meanwhile_is_appended():
    frames, graph = KeyFrames(LASER), PoseGraph()
    for _ in range(4):
        go_round(frames, graph, ROOM)
    thinned = thin(frames.snapshot(), graph.copy(), Chosen(0, np.zeros(len(frames), np.bool_)), PARAMETERS)
    left = len(thinned.frames)
    go_round(frames, graph, ROOM, 2)
    later = thinned.with_later_nodes(graph)
    assert later.node_count == len(thinned.with_later_frames(frames)) == left + 2
    np.testing.assert_array_equal(later.poses[-1], graph.poses[-1])
    assert later.edges.second.max() == left + 1


def test_a_later_edge_to_a_removed_key_frame_gives_the_result_up():
    frames, graph = KeyFrames(LASER), PoseGraph()
    for _ in range(4):
        go_round(frames, graph, ROOM)
    thinned = thin(frames.snapshot(), graph.copy(), Chosen(0, np.zeros(len(frames), np.bool_)), PARAMETERS)
    removed = int(np.flatnonzero(~thinned.kept)[0])
    node = graph.add_node(graph.poses[-1])
    graph.add_edge(removed, node, (0.0, 0.0, 0.1), np.eye(3), EdgeKind.ODOMETRY)
    assert thinned.with_later_nodes(graph) is None


def test_waiting_closures_are_renumbered():
    graph = PoseGraph()
    for _ in range(10):
        graph.add_node((0.0, 0.0, 0.0))
    graph.add_edge(1, 8, (0.0, 0.0, 0.0), np.eye(3), EdgeKind.CLOSURE)
    waiting = Closure(Submap(6, 9), Submap(0, 3), graph.edges, 0.9, Pose2D(0.0, 0.0, 0.0), True)
    kept = ~np.isin(np.arange(10), (0, 4, 7))
    (moved,) = renumbered_closures([waiting], kept)
    assert (moved.source, moved.target) == (Submap(4, 6), Submap(0, 2))
    assert (moved.edges.first.tolist(), moved.edges.second.tolist()) == ([0], [5])
    assert renumbered_closures([waiting], np.arange(10) != 8) == []


def test_a_thinning_is_due_after_enough_new_key_frames():
    settings = LifelongParameters(least_new_frames=32)
    assert not is_due(31, 0, settings) and is_due(32, 0, settings)
    assert not is_due(1100, 1000, settings) and is_due(1125, 1000, settings)
