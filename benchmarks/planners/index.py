"""The index of a map: how long it takes to make, by number of threads, and how fast and right its queries are."""

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from rich.progress import Progress

from benchmarks.planners.grids import SEED, Grid
from benchmarks.planners.scenario import Asked, ScenarioScene, ask_all, walked, warm
from benchmarks.planners.timing import announce, cpus, least
from ppaas.errors import InvalidMap, InvalidParameter
from ppaas.maps.formats.movingai import Scenario
from ppaas.planners import create
from ppaas.planners.prepared import PreparedPlanner
from ppaas.planners.weights import passable

RUNS, BUDGET = 3, 12.0
"""Times that an index is made, fewer where that would take longer than so many seconds."""

QUERIES = 1000
DRAWN = 4
"""How many times as many pairs of cells are drawn: some have no way between them."""

JUDGE = "jps"
"""Whose paths tell how long a shortest one is; `scenario` tells whether they are right."""


def measure(
    grid: Grid, name: str, threads: Sequence[int], progress: Progress, queries: int = QUERIES
) -> dict[str, Any]:
    """Make an index on each number of threads, and ask it for ways between cells that are drawn at random.

    Parameters
    ----------
    grid : Grid
    name : str
        Of a planner that prepares a map.
    threads : sequence of int
    progress : Progress
        Is told how far this is.
    queries : int
        Most of them.

    Returns
    -------
    dict
        ``grid``, ``planner``, ``seconds`` by number of threads, ``bytes``, ``queries``, ``wrong`` ones, ``mean_us``,
        ``p50_us``, ``p99_us``, ``cpus``.

    Raises
    ------
    InvalidMap
        No way between any two cells was found.
    InvalidParameter
        The planner prepares no map.
    InvalidPlanner
        It makes no index of this one.
    """
    planner = create(name)
    if not isinstance(planner, PreparedPlanner):
        raise InvalidParameter(f"{name} makes no index of a map; hub_labels and jps do")
    announce(progress, f"index: {grid.name} by {name}")
    warm(planner)
    seconds, prepared = {}, None
    for n in threads:
        del prepared  # its memory is the next one's
        making = partial(planner.prepare, grid.costmap, threads=n)
        seconds[str(n)], prepared = least(making, BUDGET, RUNS)
    assert prepared is not None
    scene = drawn(grid, queries)
    return {
        "grid": grid.name, "planner": name, "seconds": seconds, "bytes": prepared.nbytes,
        **ask_all(Asked(lambda *ends: partial(prepared.path, *ends)), scene, progress, grid.name), "cpus": cpus(),
    }  # fmt: skip


def drawn(grid: Grid, count: int) -> ScenarioScene:
    """Return so many queries between cells that are drawn at random, or fewer where most have no way between them."""
    free = passable(True)[grid.costmap.data]
    cells = np.argwhere(free)
    judge = create(JUDGE)
    assert isinstance(judge, PreparedPlanner)
    ways = judge.prepare(grid.costmap)
    pairs = cells[np.random.default_rng(SEED).integers(0, len(cells), (DRAWN * count if len(cells) else 0, 2))]
    found = []
    for row, column, to_row, to_column in pairs.reshape(-1, 4).tolist():
        ends = [row, column, to_row, to_column]
        length = walked(free, ways.path(row, column, to_row, to_column), ends)
        if not np.isnan(length):
            found.append((*ends, length))
        if len(found) == count:
            break
    if not found:
        raise InvalidMap("no two cells with a way between them were found on the map")
    starts, goals, lengths = np.split(np.array(found), (2, 4), axis=1)
    return ScenarioScene(grid.name, Scenario(starts.astype(int), goals.astype(int), lengths.ravel()), grid.costmap)
