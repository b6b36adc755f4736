"""Planner that reads shortest paths from an index of the map."""

from collections.abc import Callable
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.errors import InvalidInput
from ppaas.planners.ends import Ends
from ppaas.planners.grid_planner import Found
from ppaas.planners.hub_labels.building.assembly import build_index
from ppaas.planners.hub_labels.building.graph import Rectangle
from ppaas.planners.hub_labels.building.header import fingerprint, unseal
from ppaas.planners.hub_labels.index import HubIndex
from ppaas.planners.prepared import PreparedPlanner
from ppaas.planners.traits import Optimal, Traits
from ppaas.planners.watch import proceed
from ppaas.planners.weights import passable

Free = NDArray[np.bool_]


class HubLabels(PreparedPlanner):
    """Plans with hub labels over the corners of a map.

    The first index that it builds or opens is that of the bare map. If a robot sees obstacles that are not on the map,
    a path of that index is still a shortest one as long as no obstacle is on it. The index is repaired only if there is
    one, or if cells that are blocked on the map are free now.
    """

    name: ClassVar[str] = "hub_labels"
    purpose: ClassVar[str] = (
        "Shortest path in microseconds, from an index built once per map and robot radius; cells are free or "
        "blocked, their graded costs are ignored."
    )
    traits: ClassVar[Traits] = Traits(optimal=Optimal.UNIFORM, weighted=False, indexed=True)

    def __init__(self, *, allow_unknown: bool = True, smooth: bool = False) -> None:
        super().__init__(allow_unknown=allow_unknown, smooth=smooth)
        self._bare: tuple[Free, HubIndex] | None = None
        self._repaired: HubIndex | None = None

    def prepare(self, costmap: Costmap, *, threads: int = 1, check: Callable[[], None] = proceed) -> HubIndex:
        """Open the shared index of a map, or build one.

        Raises
        ------
        InvalidPlanner
            The map is too large or too cluttered for an index.
        """
        free = self._free(costmap)
        found = self._shared(costmap, check)
        if found is not None and found.is_of(fingerprint(free)):
            return found
        return HubIndex(build_index(free, threads=threads, check=check))

    def search(self, costmap: Costmap, ends: Ends, *, threads: int, check: Callable[[], None]) -> Found:
        """Return the cells of a shortest path between two ends."""
        if not costmap.data.flags.writeable:
            return super().search(costmap, ends, threads=threads, check=check)
        free = self._free(costmap)
        bare_free, bare = self._bare_map(costmap, free, threads, check)
        if not (free & ~bare_free).any():
            cells = bare.path(*ends.start, *ends.goal)
            if are_free(free, cells):
                return Found(cells, bare.expanded)
        index = self._index_of(free, bare_free, bare, threads, check)
        return Found(index.path(*ends.start, *ends.goal), index.expanded)

    def twin(self) -> Self:
        """Return a planner with the same parameters for another thread; it shares the index of the bare map."""
        twin = super().twin()
        if self._bare is not None:
            twin._bare = self._bare[0], self._bare[1].twin()
        return twin

    def _free(self, costmap: Costmap) -> Free:
        return passable(self.allow_unknown)[costmap.data]

    def _shared(self, costmap: Costmap, check: Callable[[], None]) -> HubIndex | None:
        """Return the shared index of the bare map; None if there is none, or it cannot be read."""
        content = costmap.indexes(self.name, check) if costmap.indexes is not None else None
        if content is None:
            return None
        try:
            return HubIndex(unseal(content))
        except InvalidInput:
            return None

    def _bare_map(self, costmap: Costmap, free: Free, threads: int, check: Callable[[], None]) -> tuple[Free, HubIndex]:
        if self._bare is None or self._bare[0].shape != free.shape:
            found = self._shared(costmap, check)
            if found is not None and (bare_free := found.free()).shape == free.shape:
                self._bare = bare_free, found
            else:
                self._bare = free, HubIndex(build_index(free, threads=threads, check=check))
        return self._bare

    def _index_of(
        self, free: Free, bare_free: Free, bare: HubIndex, threads: int, check: Callable[[], None]
    ) -> HubIndex:
        wanted = fingerprint(free)
        for index in (bare, self._repaired):
            if index is not None and index.is_of(wanted):
                return index
        self._repaired = bare.repaired(free, differing(bare_free, free), threads=threads, check=check)
        return self._repaired


def differing(bare_free: Free, now: Free) -> Rectangle:
    """Return the smallest rectangle that contains all differences of two maps."""
    changed = bare_free != now
    rows, columns = (np.flatnonzero(changed.any(axis=axis)) for axis in (1, 0))
    if not len(rows):
        return slice(0, 0), slice(0, 0)
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)


def are_free(free: Free, cells: NDArray[np.int32]) -> bool:
    """Return whether a path is free, including the cells beside its diagonal moves."""
    rows, columns = cells.T
    beside = free[rows[1:], columns[:-1]] & free[rows[:-1], columns[1:]]
    return bool(free[rows, columns].all() and beside.all())
