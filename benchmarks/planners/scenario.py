"""Bench of MovingAI scenarios: time of every query, and whether its path is valid and as short as the optimum."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.progress import Progress

from benchmarks.planners import grids
from benchmarks.planners.timing import BUDGET, RUNS, announce, cpus, timed
from ppaas.clock import monotonic
from ppaas.costmap.costmap import Costmap
from ppaas.errors import InvalidMap, InvalidParameter, PlanningError
from ppaas.geometry import Pose2D
from ppaas.maps.formats.movingai import Scenario, parse_scenario
from ppaas.planners import create
from ppaas.planners.base import Planner, PlanRequest, PlanResult
from ppaas.planners.prepared import PreparedPlanner
from ppaas.planners.watch import proceed
from ppaas.planners.weights import SQRT2, passable

TOLERANCE = 0.01
"""Largest difference of a length from the scenario's optimum [cells]."""

BLOCK, LONGEST = 2048, 1.0
"""Largest number of queries, and approximate time [s], before their answers are checked. The check evicts the caches:
after every 256 queries, it slowed queries of hub labels by a fifth on average."""

_NO_CELLS = np.empty((0, 2), np.int32)
_WARM = grids.random(64, 10.0)

Query = Callable[[], PlanResult | NDArray[np.int32]]


@dataclass(frozen=True, slots=True)
class ScenarioScene:
    """Queries of a scenario, their map, and its name."""

    name: str
    queries: Scenario
    costmap: Costmap


@dataclass(frozen=True, slots=True)
class Asked:
    """A planner that is prepared for a map.

    Parameters
    ----------
    question : callable
        Returns the call that computes a path, from two cells (row, column, row, column).
    index_seconds : float
        Time to prepare the map [s]; 0 if the planner prepares none.
    index_bytes : int
        Size of the prepared data [bytes].
    """

    question: Callable[[int, int, int, int], Query]
    index_seconds: float = 0.0
    index_bytes: int = 0


def measure(scenario: Path, map_: Path | None, planner: str, limit: int | None, progress: Progress) -> dict[str, Any]:
    """Time each query of a scenario alone.

    Parameters
    ----------
    scenario : Path
        A ``.scen`` file.
    map_ : Path, optional
        File of its map; by default the one beside it.
    planner : str
        Name of a planner. If it prepares a map, it does so once on all CPUs, and its kernel interface is timed;
        otherwise all of ``plan`` is timed, on all CPUs.
    limit : int, optional
        Number of first queries to use; all by default.
    progress : Progress
        Display of the progress.

    Returns
    -------
    dict
        ``planner``, ``queries``, ``wrong`` ones, ``mean_us``, ``p50_us``, ``p99_us``, ``index_seconds``,
        ``index_bytes``.

    Raises
    ------
    InvalidMap
        One of the files cannot be read, or the queries do not fit the map.
    InvalidParameter
        The limit is below 1.
    NotFound
        The planner is unknown.
    """
    if limit is not None and limit < 1:
        raise InvalidParameter(f"--limit, the largest number of queries, must be 1 or more, not {limit}")
    create(planner)  # report an unknown planner before reading files
    scene = read(scenario, map_)
    return ask(planner, replace(scene, queries=scene.queries.first(limit)), progress)


def read(scenario: Path, map_: Path | None = None) -> ScenarioScene:
    """Read a scenario and its map, by default the one beside it.

    Raises
    ------
    InvalidMap
        One of the files cannot be read, or the queries do not fit the map.
    """
    try:
        queries = parse_scenario(scenario.read_bytes())
    except OSError as error:
        raise InvalidMap(f"cannot read the scenario: {error}") from error
    costmap = grids.from_file(map_ or map_beside(scenario)).costmap
    check_belongs(queries, costmap)
    return ScenarioScene(map_beside(scenario).stem, queries, costmap)


def ask(planner: str, scene: ScenarioScene, progress: Progress, check: Callable[[], None] = proceed) -> dict[str, Any]:
    """Time each query alone; return the result of ``measure``. ``check`` may abort the preparation of the map."""
    what = f"{scene.name} by {planner}"
    announce(progress, f"scenario: {what}, {len(scene.queries):,} queries")
    chosen = create(planner)
    warm(chosen)
    asked = on_map(chosen, scene.costmap, check)
    answered = ask_all(asked, scene, progress, what)
    return {
        "planner": planner,
        **answered,
        "index_seconds": asked.index_seconds,
        "index_bytes": asked.index_bytes,
    }


def map_beside(scenario: Path) -> Path:
    """Return the path of the map beside a scenario: ``A.map`` for ``A.map.scen``."""
    return scenario.with_suffix("")


def check_belongs(queries: Scenario, costmap: Costmap) -> None:
    """Raise ``InvalidMap`` unless there are queries, and all start and end in free cells of the map."""
    if not len(queries):
        raise InvalidMap("the scenario has no queries")
    free = passable(True)[costmap.data]
    for what, cells in (("begins", queries.starts), ("ends", queries.goals)):
        inside = np.all((cells >= 0) & (cells < np.array(free.shape)), axis=1)
        good = inside & free[tuple(np.where(inside[:, np.newaxis], cells, 0).T)]
        if not good.all():
            number = int(np.argmin(good))
            cell = tuple(cells[number].tolist())
            raise InvalidMap(f"query {number} {what} in row, column {cell}, which is not free: is this the right map?")


def warm(planner: Planner) -> None:
    """Plan on a small map, so that kernels are compiled or loaded before anything is timed."""
    asked = on_map(planner, _WARM.costmap)
    free = np.argwhere(_WARM.costmap.data == 0)
    answer(asked.question(*free[0].tolist(), *free[-1].tolist()))


def on_map(planner: Planner, costmap: Costmap, check: Callable[[], None] = proceed) -> Asked:
    """Prepare a planner for queries on a map; ``check`` may abort the preparation."""
    threads = cpus()
    if isinstance(planner, PreparedPlanner):
        seconds, prepared = timed(lambda: planner.prepare(costmap, threads=threads, check=check))
        return Asked(lambda *ends: partial(prepared.path, *ends), seconds, prepared.nbytes)
    return Asked(lambda *ends: partial(planner.plan, costmap, _request(costmap, ends, threads)))


def ask_all(asked: Asked, scene: ScenarioScene, progress: Progress, what: str) -> dict[str, Any]:
    """Time each query alone, in the fastest of several rounds over all queries, and count wrong answers.

    There are `RUNS` rounds, or fewer if they would take longer than `BUDGET`.

    Returns
    -------
    dict
        ``queries``, ``wrong`` ones, ``mean_us``, ``p50_us``, ``p99_us``.
    """
    free = passable(True)[scene.costmap.data]
    ends, optima = np.hstack((scene.queries.starts, scene.queries.goals)).tolist(), scene.queries.optima
    questions = [asked.question(*own) for own in ends]
    answer(questions[0])  # warm-up: the preparation leaves cold caches
    best, wrong = np.full(len(ends), np.inf), np.zeros(len(ends), bool)
    task = progress.add_task(what, total=len(ends))
    for number in range(RUNS):
        if number and number * best.sum() > BUDGET:
            break
        seconds, first = np.empty(len(ends)), 0
        while first < len(ends):
            took, answers = ask_some(questions[first : first + BLOCK])
            block = slice(first, first + len(answers))
            lengths = [walked(free, cells, own) for cells, own in zip(answers, ends[block], strict=True)]
            seconds[block], first = took, block.stop
            wrong[block] |= ~(np.abs(lengths - optima[block]) <= TOLERANCE)
            if not number:
                progress.update(task, completed=first)
        best = min(best, seconds, key=np.sum)
    mean, half, most = 1e6 * np.array((best.mean(), *np.percentile(best, (50, 99))))
    return {
        "queries": len(ends),
        "wrong": int(wrong.sum()),
        "mean_us": float(mean),
        "p50_us": float(half),
        "p99_us": float(most),
    }


def ask_some(questions: Sequence[Query]) -> tuple[list[float], list[NDArray[np.int32]]]:
    """Run one or more of the first queries; return the time of each [s], and the cells of its path."""
    seconds, answers, last = list[float](), list[NDArray[np.int32]](), monotonic() + LONGEST
    for question in questions:
        began = monotonic()
        if seconds and began > last:
            break
        try:
            found = question()
            took = monotonic() - began
        except PlanningError:
            found, took = _NO_CELLS, monotonic() - began
        seconds.append(took)
        answers.append(_cells_of(found))
    return seconds, answers


def answer(question: Query) -> NDArray[np.int32]:
    """Return the cells of a path; empty if the planner finds none."""
    try:
        return _cells_of(question())
    except PlanningError:
        return _NO_CELLS


def _cells_of(found: PlanResult | NDArray[np.int32]) -> NDArray[np.int32]:
    return found.cells if isinstance(found, PlanResult) else found


def walked(free: NDArray[np.bool_], cells: NDArray[np.integer], ends: list[int]) -> float:
    """Check a path and return its octile length [cells].

    Parameters
    ----------
    free : (height, width) bool array
    cells : (n, 2) array
        Row, column.
    ends : list of int
        Row and column of the start, and of the goal.

    Returns
    -------
    float
        NaN for an invalid path: it does not join the ends, leaves the map or the free cells, skips a cell, or cuts a
        corner.
    """
    if not len(cells) or [*cells[0].tolist(), *cells[-1].tolist()] != ends:
        return float("nan")
    if (cells < 0).any() or (cells >= free.shape).any() or not free[cells[:, 0], cells[:, 1]].all():
        return float("nan")
    before, after = cells[:-1], cells[1:]
    steps = np.abs(after - before)
    corners = free[before[:, 0], after[:, 1]] & free[after[:, 0], before[:, 1]]
    if not (corners.all() and (steps.max(axis=1, initial=0) == 1).all()):
        return float("nan")
    diagonals = int((steps.sum(axis=1) == 2).sum())
    return len(steps) - diagonals + diagonals * SQRT2


def _request(costmap: Costmap, ends: tuple[int, ...], threads: int) -> PlanRequest:
    start, goal = (Pose2D(*costmap.info.to_world(cell).tolist()) for cell in (ends[:2], ends[2:]))
    return PlanRequest(start, goal, threads=threads)
