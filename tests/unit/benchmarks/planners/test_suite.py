"""A suite measures every requested part, and reports omitted measurements."""

from pathlib import Path

import numpy as np
import pytest
from rich.progress import Progress

from benchmarks.commands.planners import SuiteBench
from benchmarks.planners import grids, index, path_lengths, report, suite
from ppaas.errors import InvalidInput, InvalidMap, InvalidParameter, InvalidPlanner
from ppaas.maps.generate import warehouse
from ppaas.planners.hub_labels.kernels.query import entry
from ppaas.planners.hub_labels.planner import HubIndex

SCENARIO = {
    "map": "arena", "planner": "jps", "queries": 130, "wrong": 0, "mean_us": 12.25, "p50_us": 10.0, "p99_us": 40.0,
    "index_seconds": 0.5, "index_bytes": 2_000_000,
}  # fmt: skip


def test_every_known_part_is_measured() -> None:
    assert set(SuiteBench.PARTS) == set(suite.PARTS)


def test_real_maps_are_measured_and_every_part_can_be_rendered(data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(suite, "ROS_MAPS", ("tb3_sandbox.yaml",))
    monkeypatch.setattr(suite, "PREPARED", ("jps",))
    monkeypatch.setattr(suite, "SAMPLED", ("dijkstra",))
    monkeypatch.setattr(suite, "QUICK_SAMPLE", 2)
    options = suite.PlannerSuiteOptions(data, ("fields", "scaling", "scenarios"), quick=True)
    with Progress(disable=True) as progress:
        measured = dict(suite.measure(options, progress))
    assert list(measured) == ["machine", "fields", "scaling", "scenarios"]
    scenes = list((data / "movingai").glob("*/*.scen"))
    assert {row["map"] for row in measured["scenarios"]} == {file.name.removesuffix(".map.scen") for file in scenes}
    assert {(row["planner"], row["queries"], row["wrong"]) for row in measured["scenarios"]} == {
        ("jps", 2, 0), ("dijkstra", 2, 0),
    }  # fmt: skip
    text = report.render(measured)
    assert "| tb3_sandbox | 137,448 | 1 |" in text and "| empty | 1 |" in text
    assert "A quick run" in text and "| 2 of 950 |" in text


def test_a_map_whose_index_takes_too_long_is_left_out(
    data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "movingai" / "dao").mkdir(parents=True)
    for file in (data / "movingai" / "dao").glob("arena2.*"):
        (tmp_path / "movingai" / "dao" / file.name).symlink_to(file)
    monkeypatch.setattr(suite, "PREPARED", ("jps",))
    monkeypatch.setattr(suite, "SAMPLED", ())
    monkeypatch.setattr(suite, "PATIENCE", -1.0)
    with Progress(disable=True) as progress:
        scenarios = dict(suite.measure(suite.PlannerSuiteOptions(tmp_path, ("scenarios",), quick=True), progress))[
            "scenarios"
        ]
    assert {tuple(row["left_out"]) for row in scenarios} == {("jps",)}
    assert "arena2" in report.render({"scenarios": scenarios})
    assert "arena2" in report.render({"scenarios": [{**SCENARIO, "of": 130}, *scenarios]})


def test_a_missing_folder_is_refused(tmp_path: Path) -> None:
    with Progress(disable=True) as progress, pytest.raises(InvalidInput, match="--data"):
        list(suite.measure(suite.PlannerSuiteOptions(tmp_path / "none"), progress))


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


SMALL = warehouse(seed=1, width=15.0, height=8.0)


def test_path_lengths_grow_in_equal_steps_to_nearly_the_longest() -> None:
    questions = path_lengths.questions(grids.empty(101).costmap, points=4)
    assert len({question.goal for question in questions}) == 1
    # From corner to corner of a square of 5 m it is 7.07 m.
    np.testing.assert_allclose([question.length for question in questions], np.arange(1, 5) * 7.07 / 4, atol=0.08)


async def test_every_number_of_threads_has_its_curve() -> None:
    with Progress(disable=True) as progress:
        result = await path_lengths.measure_locally(grids.empty(64).costmap, [1, 2], progress)
    assert list(result["seconds"]) == ["dijkstra, 1 thread", "dijkstra, 2 threads"]
    assert all(len(curve) == len(result["length_m"]) == path_lengths.POINTS for curve in result["seconds"].values())
    title, lines, _, _ = path_lengths.chart(result)
    assert "4,096 cells" in title
    assert lines[0].points[0] == (result["length_m"][0], 1e3 * result["seconds"]["dijkstra, 1 thread"][0])


@pytest.mark.journey
async def test_a_container_with_many_cores_is_timed_from_request_to_answer() -> None:
    with Progress(disable=True) as progress:
        result = await path_lengths.measure(SMALL, 2, progress, points=2)
    curves = result["seconds"]
    assert set(curves) == {
        "dijkstra, 1 thread", "dijkstra, 2 threads", "dijkstra, container of 2 cores, request to answer",
        "navfn, 1 thread",
    }  # fmt: skip
    assert all(0.0 < seconds < float("inf") for curve in curves.values() for seconds in curve)
