"""Maps of tasks: where robots charge and park on them, and lengths of ways by the costs of planners."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from engine.control.planning.requests import CostAnswer
from engine.specs.containers import MapVersion
from ppaas.decoding import from_json
from ppaas.energy.sites import NO_SITES, Sites, sites_of
from ppaas.errors import NotFound
from ppaas.maps.formats.map_files import read_info
from ppaas.tasks.assignment import Distance
from ppaas.tasks.reach import free_length, straight
from ppaas.tasks.records import Place
from ppaas.zones.reading import zones_of
from storage.map_port import MapStore
from storage.versions import IMAGE, YAML, ZONES


class TaskMap(NamedTuple):
    """Version of a map on which tasks are done: where robots charge and park, and the size of a cell [m].

    The size is None if the map is removed or has no grid; distances are straight lines then.
    """

    version: MapVersion
    sites: Sites = NO_SITES
    resolution: float | None = None


def task_map_on(maps: MapStore, version: MapVersion) -> TaskMap:
    """Return what tasks need of a version of a map; may block."""
    try:
        with maps.open_map(version.id, version.version, only=(YAML, IMAGE, ZONES)) as opened:
            sites = sites_of(zones_of(bytes(opened.buffers[ZONES]))) if ZONES in opened.buffers else NO_SITES
            has_grid = YAML in opened.buffers and IMAGE in opened.buffers
            return TaskMap(version, sites, read_info(*opened.grid()).resolution if has_grid else None)
    except NotFound:
        return TaskMap(version)


def distance_by(answer: CostAnswer, starts: Sequence[Place], goals: Sequence[Place], resolution: float) -> Distance:
    """Return the lengths of the ways of a matrix of costs; between other places, straight lines.

    A way near obstacles counts as longer, by its cost.

    Parameters
    ----------
    answer : CostAnswer
        Costs from each start to each goal.
    starts, goals : sequence of Place
    resolution : float
        Size of a cell of the map [m].
    """
    rows = from_json(bytes(answer.costs), list[list[float | None]])
    known: dict[tuple[Place, Place], float] = {
        (start, goal): math.inf if cost is None else free_length(cost, resolution)
        for start, row in zip(starts, rows, strict=True)
        for goal, cost in zip(goals, row, strict=True)
    }
    return lambda start, goal: known.get((start, goal), straight(start, goal))
