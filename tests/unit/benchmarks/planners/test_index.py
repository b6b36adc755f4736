"""Results of the index bench: queries join connected cells, and wrong answers are counted."""

import numpy as np
import pytest
from rich.progress import Progress

from benchmarks.planners import grids, index
from ppaas.errors import InvalidMap, InvalidParameter, InvalidPlanner
from ppaas.planners.hub_labels.kernels.query import entry
from ppaas.planners.hub_labels.planner import HubIndex


def measure(grid: grids.Grid, planner: str = "hub_labels", threads: tuple[int, ...] = (1,)) -> dict:
    with Progress(disable=True) as progress:
        return index.measure(grid, planner, threads, progress, 20)


@pytest.mark.parametrize("planner", ["hub_labels", "jps"])
def test_every_number_of_threads_is_timed_and_no_query_is_wrong(planner):
    result = measure(grids.random(64, 10.0), planner, (1, 2))
    assert set(result["seconds"]) == {"1", "2"}
    assert (result["grid"], result["planner"]) == ("random 10 % 64²", planner)
    assert (result["queries"], result["wrong"]) == (20, 0)
    assert (result["plans"], result["seen_wrong"]) == (20, 0)
    assert min(result["map_us"], result["seen_us"]) > 0.0
    assert result["bytes"] > 0


def test_a_longer_path_counts_as_wrong(monkeypatch):
    find = entry()
    detour = np.array([[0, 0], [0, 1], [0, 0]], np.int32)

    def path(self, row, column, to_row, to_column, check=None):
        cells = find(self.words, self._scratch, row, column, to_row, to_column)
        return cells if row % 2 else np.concatenate((cells[:1] + detour, cells))

    monkeypatch.setattr(HubIndex, "path", path)
    assert 0 < measure(grids.empty(16))["wrong"] < 20


def test_queries_connect_cells_of_one_region():
    costs = grids.empty(20).costmap.data.copy()
    costs[10] = 254
    scene = index.random_queries(grids._grid("two rooms", costs), 30)
    assert len(scene.queries) == 30
    assert ((scene.queries.starts[:, 0] < 10) == (scene.queries.goals[:, 0] < 10)).all()


def test_a_fully_occupied_map_is_refused():
    with pytest.raises(InvalidMap, match="no two connected free cells"):
        index.random_queries(grids._grid("walls", np.full((3, 3), 254, np.uint8)), 5)


def test_a_planner_without_an_index_is_refused():
    with pytest.raises(InvalidParameter, match="'dijkstra' builds no index"):
        measure(grids.empty(9), "dijkstra")


def test_a_map_that_the_planner_refuses_is_reported(monkeypatch):
    from ppaas.planners.hub_labels.building import size_limits

    monkeypatch.setattr(size_limits, "MOST_BYTES", 1.0)
    with pytest.raises(InvalidPlanner, match="too many"):
        measure(grids.random(200, 20.0))
