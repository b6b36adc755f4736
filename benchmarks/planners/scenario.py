"""Every query of a MovingAI scenario: how long it takes, and whether the path is one and as short as can be."""

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
"""By which a length may differ from the scenario's optimum [cells]."""

BLOCK, LONGEST = 2048, 1.0
"""Most queries, and about how long [s], are asked one after the other before their answers are looked at, which leaves
the caches to other data: where that was after each 256 queries, those of hub labels took a fifth more in the mean."""

_NO_CELLS = np.empty((0, 2), np.int32)
_WARM = grids.random(64, 10.0)

Query = Callable[[], PlanResult | NDArray[np.int32]]


@dataclass(frozen=True, slots=True)
class ScenarioScene:
    """The queries of a scenario, or some of them, on their map, and what that is called."""

    name: str
    queries: Scenario
    costmap: Costmap


@dataclass(frozen=True, slots=True)
class Asked:
    """A planner on a map.

    Parameters
    ----------
    question : callable
        Makes of two cells, (row, column, row, column), what is called to have a path.
    index_seconds : float
        That the planner took to prepare the map; 0 if it prepares none.
    index_bytes : int
        That what it prepared takes.
    """

    question: Callable[[int, int, int, int], Query]
    index_seconds: float = 0.0
    index_bytes: int = 0


def measure(scenario: Path, map_: Path | None, planner: str, limit: int | None, progress: Progress) -> dict[str, Any]:
    """Time each query by itself.

    Parameters
    ----------
    scenario : Path
        A ``.scen`` file.
    map_ : Path, optional
        Of its map; else it is looked for beside it.
    planner : str
        Name of any planner. One that prepares a map does that once, on all CPUs, and its kernel interface is timed;
        of another ``plan`` as a whole, on all CPUs.
    limit : int, optional
        Most queries, the scenario's first.
    progress : Progress
        Is told how far this is.

    Returns
    -------
    dict
        ``planner``, ``queries``, ``wrong`` ones, ``mean_us``, ``p50_us``, ``p99_us``, ``index_seconds``,
        ``index_bytes``.

    Raises
    ------
    InvalidMap
        One of the files cannot be read, or they do not belong together.
    InvalidParameter
        The limit is below 1.
    NotFound
        No such planner.
    """
    if limit is not None and limit < 1:
        raise InvalidParameter(f"--limit is the most queries to ask, from 1 up, not {limit}")
    create(planner)  # that there is none is told before files are read
    scene = read(scenario, map_)
    return ask(planner, replace(scene, queries=scene.queries.first(limit)), progress)


def read(scenario: Path, map_: Path | None = None) -> ScenarioScene:
    """Return what a scenario asks; its map lies beside it if it is not told.

    Raises
    ------
    InvalidMap
        One of the files cannot be read, or they do not belong together.
    """
    try:
        queries = parse_scenario(scenario.read_bytes())
    except OSError as error:
        raise InvalidMap(f"cannot read the scenario: {error}") from error
    costmap = grids.from_file(map_ or map_beside(scenario)).costmap
    check_belongs(queries, costmap)
    return ScenarioScene(map_beside(scenario).stem, queries, costmap)


def ask(planner: str, scene: ScenarioScene, progress: Progress, check: Callable[[], None] = proceed) -> dict[str, Any]:
    """Time each query by itself, and return what ``measure`` does; ``check`` may end the preparing of the map."""
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
    """Return the map that lies beside a scenario: ``A.map`` for ``A.map.scen``."""
    return scenario.with_suffix("")


def check_belongs(queries: Scenario, costmap: Costmap) -> None:
    """Raise ``InvalidMap`` unless there are queries, and all of them begin and end in free cells of the map."""
    if not len(queries):
        raise InvalidMap("the scenario has no queries")
    free = passable(True)[costmap.data]
    for what, cells in (("begins", queries.starts), ("ends", queries.goals)):
        inside = np.all((cells >= 0) & (cells < np.array(free.shape)), axis=1)
        good = inside & free[tuple(np.where(inside[:, np.newaxis], cells, 0).T)]
        if not good.all():
            number = int(np.argmin(good))
            cell = tuple(cells[number].tolist())
            raise InvalidMap(f"query {number} {what} in row, column {cell}, not free on this map: is it the right one?")


def warm(planner: Planner) -> None:
    """Let a planner plan on a small map, so that its kernels are compiled or loaded before anything is timed."""
    asked = on_map(planner, _WARM.costmap)
    free = np.argwhere(_WARM.costmap.data == 0)
    answer(asked.question(*free[0].tolist(), *free[-1].tolist()))


def on_map(planner: Planner, costmap: Costmap, check: Callable[[], None] = proceed) -> Asked:
    """Return a planner that is ready for queries on a map; ``check`` may end what it does to prepare it."""
    threads = cpus()
    if isinstance(planner, PreparedPlanner):
        seconds, prepared = timed(lambda: planner.prepare(costmap, threads=threads, check=check))
        return Asked(lambda *ends: partial(prepared.path, *ends), seconds, prepared.nbytes)
    return Asked(lambda *ends: partial(planner.plan, costmap, _request(costmap, ends, threads)))


def ask_all(asked: Asked, scene: ScenarioScene, progress: Progress, what: str) -> dict[str, Any]:
    """Time each query by itself, in the round over all of them that took least, and count the answers that are wrong.

    There are `RUNS` rounds, fewer where they would take longer than `BUDGET`.

    Returns
    -------
    dict
        ``queries``, ``wrong`` ones, ``mean_us``, ``p50_us``, ``p99_us``.
    """
    free = passable(True)[scene.costmap.data]
    ends, optima = np.hstack((scene.queries.starts, scene.queries.goals)).tolist(), scene.queries.optima
    questions = [asked.question(*own) for own in ends]
    answer(questions[0])  # the first query after a map was prepared pays for what it leaves cold
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
    """Ask the first of some queries, one at least; return the seconds that each took, and the cells of the answers."""
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
    """Return the cells of an answer; none where the planner says that there is no path."""
    try:
        return _cells_of(question())
    except PlanningError:
        return _NO_CELLS


def _cells_of(found: PlanResult | NDArray[np.int32]) -> NDArray[np.int32]:
    return found.cells if isinstance(found, PlanResult) else found


def walked(free: NDArray[np.bool_], cells: NDArray[np.integer], ends: list[int]) -> float:
    """Recount how long a path is, in cells, octile.

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
        NaN if nobody can walk it: it does not join the ends, leaves the map or the free cells, skips a cell, or cuts a
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
