"""Answers of a scenario are checked, and wrong ones are counted."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from rich.progress import Progress

from benchmarks.planners import scenario
from ppaas.costmap.costmap import Costmap
from ppaas.errors import InvalidMap, InvalidParameter, NotFound, NoValidPath
from ppaas.planners.grid.dijkstra import Dijkstra
from ppaas.planners.prepared import Prepared, PreparedPlanner
from ppaas.planners.watch import proceed

ROWS = ["....", ".@..", "....", "...."]
MAP = "\n".join(["type octile", "height 4", "width 4", "map", *ROWS, ""])
QUERIES = [(0, 0, 3, 0, 3.0), (0, 0, 2, 2, 4.0), (3, 3, 0, 3, 3.0), (2, 2, 2, 2, 0.0)]
FREE = np.array([[cell == "." for cell in row] for row in ROWS])


@pytest.fixture
def files(tmp_path: Path) -> Path:
    """Return a scenario with its map beside it; its rows are start x, y, goal x, y, optimum."""
    (tmp_path / "a.map").write_text(MAP)
    lines = ["\t".join(map(str, (0, "a.map", 4, 4, *query))) for query in QUERIES]
    (tmp_path / "a.map.scen").write_text("\n".join(["version 1", *lines, ""]))
    return tmp_path / "a.map.scen"


def measure(file: Path, planner: str = "dijkstra", limit: int | None = None, map_: Path | None = None) -> dict:
    with Progress(disable=True) as progress:
        return scenario.measure(file, map_, planner, limit, progress)


class Shifted(Prepared):
    """A prepared map that spoils its answers; a few bytes large."""

    nbytes = 17

    def __init__(self, costmap: Costmap, spoil: Callable[[NDArray[np.int32]], NDArray[np.int32]]) -> None:
        self.costmap, self.spoil = costmap, spoil

    def path(self, start_row, start_column, goal_row, goal_column, check=proceed):
        ends = [[start_row, start_column], [goal_row, goal_column]]
        places = [self.costmap.info.to_world(end).tolist() for end in ends]
        from ppaas.geometry import Pose2D
        from ppaas.planners.base import PlanRequest

        request = PlanRequest(*(Pose2D(*place) for place in places))
        return self.spoil(Dijkstra().plan(self.costmap, request).cells)

    def twin(self):
        return self


def spoil_answers(monkeypatch: pytest.MonkeyPatch, spoil: Callable[[NDArray[np.int32]], NDArray[np.int32]]) -> None:
    """Replace the planner by one that prepares maps and spoils its answers."""

    class Liar(PreparedPlanner):
        name, purpose = "liar", "to be found out"

        def prepare(self, costmap, *, threads=1, check=proceed):
            return Shifted(costmap, spoil)

    monkeypatch.setattr(scenario, "create", lambda name: Liar())


def test_a_correct_planner_has_no_wrong_length(files: Path) -> None:
    result = measure(files)
    assert list(result) == [
        "planner",
        "queries",
        "wrong",
        "mean_us",
        "p50_us",
        "p99_us",
        "index_seconds",
        "index_bytes",
    ]
    assert (result["planner"], result["queries"], result["wrong"]) == ("dijkstra", 4, 0)
    assert (result["index_seconds"], result["index_bytes"]) == (0.0, 0)
    assert 0.0 < result["p50_us"] <= result["p99_us"] and result["mean_us"] > 0.0


def test_only_the_first_queries_run_under_a_limit(files: Path) -> None:
    assert measure(files, limit=3)["queries"] == 3


def test_time_and_size_of_a_prepared_map_are_measured(files: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    spoil_answers(monkeypatch, lambda cells: cells)
    result = measure(files, "liar")
    assert (result["wrong"], result["index_bytes"]) == (0, 17)
    assert result["index_seconds"] >= 0.0


def detour(cells: NDArray[np.int32]) -> NDArray[np.int32]:
    return cells if len(cells) < 2 else np.concatenate((cells[:1], cells[1:2], cells))


SPOILERS = {
    "nothing": (lambda cells: cells[:0], 4),
    "not to the goal": (lambda cells: cells[:-1] if len(cells) > 1 else cells + 1, 4),
    "turned round": (lambda cells: cells[::-1], 3),
    "skips cells": (lambda cells: cells[[0, -1]] if len(cells) > 1 else cells, 3),
    "goes back and forth": (detour, 3),
    "stands still": (lambda cells: np.concatenate((cells[:1], cells)), 4),
}


@pytest.mark.parametrize("spoiler", SPOILERS)
def test_wrong_answers_of_a_planner_are_counted(files: Path, monkeypatch: pytest.MonkeyPatch, spoiler: str) -> None:
    spoil, wrong = SPOILERS[spoiler]
    spoil_answers(monkeypatch, spoil)
    assert measure(files, "liar")["wrong"] == wrong


@pytest.mark.parametrize(("block", "longest"), [(1, 1.0), (3, 1.0), (2048, 1e-9)])
@pytest.mark.parametrize("spoiler", SPOILERS)
def test_answers_are_checked_for_any_block_size_and_time_limit(
    files: Path, monkeypatch: pytest.MonkeyPatch, spoiler: str, block: int, longest: float
) -> None:
    monkeypatch.setattr(scenario, "BLOCK", block)
    monkeypatch.setattr(scenario, "LONGEST", longest)
    spoil, wrong = SPOILERS[spoiler]
    spoil_answers(monkeypatch, spoil)
    result = measure(files, "liar")
    assert (result["queries"], result["wrong"]) == (4, wrong)


def test_a_planner_without_a_path_is_wrong(files: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(cells: NDArray[np.int32]) -> NDArray[np.int32]:
        raise NoValidPath("no way")

    spoil_answers(monkeypatch, refuse)
    assert measure(files, "liar")["wrong"] == 4


def test_an_optimum_off_by_more_than_a_hundredth_is_wrong(files: Path) -> None:
    files.write_text(files.read_text().replace("\t3.0\n", "\t3.009\n", 1).replace("\t4.0\n", "\t4.011\n"))
    assert measure(files)["wrong"] == 1


@pytest.mark.parametrize(
    ("cells", "length"),
    [
        ([[0, 0], [0, 1], [0, 2]], 2.0),
        ([[0, 2], [1, 3]], 2.0**0.5),
        ([[0, 1], [1, 2]], float("nan")),  # past the corner of the obstacle
        ([[1, 0], [1, 1], [1, 2]], float("nan")),  # through it
        ([[0, 3], [0, 4], [0, 3]], float("nan")),  # off the map
        ([[0, 0], [-1, 0], [0, 0]], float("nan")),
        ([[0, 0], [0, 2]], float("nan")),
        ([[2, 2]], 0.0),
    ],
)
def test_the_length_of_a_path_is_that_of_valid_moves_only(cells: list[list[int]], length: float) -> None:
    path = np.array(cells, np.int32)
    np.testing.assert_equal(scenario.walked(FREE, path, [*cells[0], *cells[-1]]), length)


def test_invalid_files_and_options_are_refused(files: Path, tmp_path: Path) -> None:
    with pytest.raises(InvalidMap, match="cannot read the scenario"):
        measure(tmp_path / "none.scen")
    with pytest.raises(InvalidMap, match="cannot read the map"):
        measure(files, map_=tmp_path / "none.map")
    (tmp_path / "empty.scen").write_text("version 1\n")
    with pytest.raises(InvalidMap, match="no queries"):
        measure(tmp_path / "empty.scen", map_=tmp_path / "a.map")
    with pytest.raises(InvalidParameter, match="--limit"):
        measure(files, limit=0)
    with pytest.raises(NotFound):
        measure(files, "nobody")


@pytest.mark.parametrize("start", [(1, 1), (4, 0), (-1, 0)])
def test_a_scenario_of_another_map_is_refused(files: Path, start: tuple[int, int]) -> None:
    line = "\t".join(map(str, (0, "a.map", 4, 4, *start, 3, 3, 1.0)))
    files.write_text(f"version 1\n{line}\n")
    with pytest.raises(InvalidMap, match="query 0 begins in row, column"):
        measure(files)


@pytest.mark.parametrize("name", ["dao/arena2", "rooms/32room_003"])
def test_real_scenarios_have_no_wrong_length(data: Path, name: str) -> None:
    assert measure(data / "movingai" / f"{name}.map.scen", limit=20)["wrong"] == 0
