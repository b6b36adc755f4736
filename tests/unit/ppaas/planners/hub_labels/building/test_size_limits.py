"""No index exceeds its size limit: maps that would need more are refused early."""

import numpy as np
import pytest

from ppaas.errors import InvalidPlanner
from ppaas.planners.hub_labels.building import assembly, size_limits
from ppaas.planners.hub_labels.building.assembly import build_index
from ppaas.planners.hub_labels.building.contraction import Contraction
from ppaas.planners.hub_labels.building.graph import build_corner_graph, build_corner_map
from ppaas.planners.hub_labels.kernels import layout
from ppaas.planners.hub_labels.planner import HubIndex
from ppaas.planners.watch import proceed
from tests.unit.ppaas.planners.hub_labels.test_planner import assert_all_paths_are_shortest


def scattered(blocked: float, size: int = 100):
    return np.random.default_rng(5).random((size, size)) >= blocked


def corner_map_of(free):
    return build_corner_map(free, threads=1, check=proceed)


def refuse(*_, **__):
    raise AssertionError("this step should not have been reached")


@pytest.mark.parametrize("blocked", [0.05, 0.2, 0.35])
@pytest.mark.parametrize("most", [0.3e6, 0.5e6, 0.7e6, 1.0e6, 2.0e6, 4.0e6])
def test_index_obeys_the_size_limit_or_is_refused(monkeypatch, blocked, most):
    monkeypatch.setattr(size_limits, "MOST_BYTES", most)
    free = scattered(blocked)
    try:
        words = build_index(free, threads=1, check=proceed)
    except InvalidPlanner:
        assert most < 1.0e6
        return
    assert words.nbytes <= most
    assert_all_paths_are_shortest(free, HubIndex(words), [tuple(np.argwhere(free)[0].tolist())])


@pytest.mark.parametrize(("blocked", "most"), [(0.005, 30), (0.005, 120), (0.2, 200)])
def test_labelled_corners_do_not_exceed_the_number_of_hubs(monkeypatch, blocked, most):
    free = scattered(blocked)
    assert build_index(free, threads=1, check=proceed)[layout.LABELLED] > most
    monkeypatch.setattr(layout, "MOST_HUBS", most)
    words = build_index(free, threads=1, check=proceed)
    assert words[layout.LABELLED] <= most
    assert_all_paths_are_shortest(free, HubIndex(words), [tuple(np.argwhere(free)[0].tolist())])


def test_too_large_index_is_rebuilt_with_fewer_labels(monkeypatch):
    monkeypatch.setattr(size_limits, "MOST_BYTES", 1.0e6)
    monkeypatch.setattr(size_limits, "BYTES_AN_EDGE", 12)
    monkeypatch.setattr(size_limits, "BYTES_A_CORNER", 0)
    limits = []
    usual = assembly.label
    monkeypatch.setattr(assembly, "label", lambda *a, **k: (limits.append(k["most_entries"]), usual(*a, **k))[1])
    assert build_index(scattered(0.2), threads=1, check=proceed).nbytes <= 1.0e6
    assert limits == sorted(limits, reverse=True)
    assert len(limits) > 1


def test_map_with_too_many_corners_is_refused_before_contraction(monkeypatch):
    monkeypatch.setattr(assembly, "Contraction", refuse)
    with pytest.raises(InvalidPlanner, match=r"342763 corners.* 40 MB; .* jps or dijkstra"):
        build_index(np.random.default_rng(0).random((1024, 1024), np.float32) >= 0.2, threads=2, check=proceed)


def test_map_with_too_many_edges_is_refused_during_contraction(monkeypatch):
    free = scattered(0.1)
    graph = build_corner_graph(corner_map_of(free), threads=1, check=proceed)
    monkeypatch.setattr(assembly, "most_edges", lambda *_: len(graph.to) * 3 // 4)
    monkeypatch.setattr(assembly, "most_label_entries", refuse)
    contractions = []
    monkeypatch.setattr(
        assembly, "Contraction", lambda *a, **k: (contractions.append(Contraction(*a, **k)), contractions[-1])[1]
    )
    with pytest.raises(InvalidPlanner, match="too many"):
        build_index(free, threads=1, check=proceed)
    assert contractions[0].core > len(graph.positions) // 4


def test_map_with_a_too_long_contraction_is_refused(monkeypatch):
    monkeypatch.setattr(size_limits, "MOST_EDGE_VISITS", 1000)
    monkeypatch.setattr(assembly, "label", refuse)
    with pytest.raises(InvalidPlanner, match="too many"):
        build_index(scattered(0.1), threads=2, check=proceed)


def test_map_without_space_for_a_core_is_refused_before_shortcuts(monkeypatch):
    monkeypatch.setattr(assembly, "DENSE_CORE_CORNERS", (0, 100))
    monkeypatch.setattr(assembly, "most_label_entries", lambda *_: 0)
    cores = []
    usual = Contraction.run
    monkeypatch.setattr(Contraction, "run", lambda *a, **k: (cores.append(a[1:]), usual(*a, **k))[1])
    with pytest.raises(InvalidPlanner, match="too many"):
        build_index(scattered(0.1), threads=1, check=proceed)
    assert cores == [()]


def test_map_without_space_for_labels_is_refused_before_labelling(monkeypatch):
    free = scattered(0.2)
    monkeypatch.setattr(assembly, "most_label_entries", lambda corner_map, _: len(corner_map.positions) // 3)
    monkeypatch.setattr(assembly, "label", refuse)
    with pytest.raises(InvalidPlanner, match="too many"):
        build_index(free, threads=1, check=proceed)


def test_map_is_dense_if_corners_see_few_others_or_are_many(monkeypatch):
    corner_map, maze = corner_map_of(scattered(0.02)), corner_map_of(scattered(0.35))
    graph = build_corner_graph(corner_map, threads=1, check=proceed)
    assert not size_limits.is_dense(corner_map, graph)
    assert size_limits.is_dense(maze, build_corner_graph(maze, threads=1, check=proceed))
    monkeypatch.setattr(
        size_limits,
        "MOST_BYTES",
        0.99 * size_limits.USUAL_ENTRIES_A_CORNER * size_limits.BYTES_AN_ENTRY * len(corner_map.positions),
    )
    assert size_limits.is_dense(corner_map, graph)


def test_limits_grow_with_the_map():
    small, large = (corner_map_of(np.ones((size, size), np.bool_)) for size in (500, 2046))
    assert (size_limits.most_bytes(small), size_limits.most_bytes(large)) == (39.5e6, 4 * 39.5e6)
    assert (
        size_limits.most_edge_visits(large)
        == 4 * size_limits.most_edge_visits(small)
        == 4 * size_limits.MOST_EDGE_VISITS
    )
