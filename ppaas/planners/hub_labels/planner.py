"""Planner that reads shortest paths from an index of the map."""

from collections.abc import Callable
from dataclasses import replace
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE, NO_INFORMATION
from ppaas.costmap.costmap import Costmap, Window
from ppaas.errors import InvalidInput
from ppaas.planners.ends import Ends
from ppaas.planners.grid_planner import Found
from ppaas.planners.hub_labels.building.assembly import build_index
from ppaas.planners.hub_labels.building.graph import Rectangle
from ppaas.planners.hub_labels.building.header import fingerprint, unseal
from ppaas.planners.hub_labels.index import HubIndex
from ppaas.planners.hub_labels.kernels.free_path import Bounds, is_free_along, opens
from ppaas.planners.prepared import PreparedPlanner
from ppaas.planners.traits import Optimal, Traits
from ppaas.planners.watch import proceed

Free = NDArray[np.bool_]


class HubLabels(PreparedPlanner):
    """Plans with hub labels over the corners of a map.

    If a robot sees obstacles that are not on the map, a path of the map's index is still a shortest one as long as no
    obstacle is on it. The index is repaired only if there is one, or if cells that are blocked on the map are free now.
    A costmap that keeps its changes is compared with the map in their windows alone. Of other writeable costmaps the
    first is taken for the map, and all cells are compared.
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
        free = self._free(costmap.data)
        found = self._shared(costmap, check)
        if found is not None and found.is_of(fingerprint(free)):
            return found
        return HubIndex(build_index(free, threads=threads, check=check))

    def search(self, costmap: Costmap, ends: Ends, *, threads: int, check: Callable[[], None]) -> Found:
        """Return the cells of a shortest path between two ends."""
        if not costmap.data.flags.writeable:
            return super().search(costmap, ends, threads=threads, check=check)
        bare = self._bare_index(costmap, threads, check)
        if self._only_closes(costmap):
            cells = bare.path(*ends.start, *ends.goal)
            if is_free_along(costmap.data, cells, self.allow_unknown):
                return Found(cells, bare.expanded)
        index = self._index_of(costmap, bare, threads, check)
        return Found(index.path(*ends.start, *ends.goal), index.expanded)

    def twin(self) -> Self:
        """Return a planner with the same parameters for another thread; it shares the index of the bare map."""
        twin = super().twin()
        if self._bare is not None:
            twin._bare = self._bare[0], self._bare[1].twin()
        return twin

    def _shared(self, costmap: Costmap, check: Callable[[], None]) -> HubIndex | None:
        """Return the shared index of the bare map; None if there is none, or it cannot be read."""
        content = costmap.indexes(self.name, check) if costmap.indexes is not None else None
        if content is None:
            return None
        try:
            return HubIndex(unseal(content))
        except InvalidInput:
            return None

    # -- a map with obstacles that a robot sees ------------------------------------------------------------------------

    def _bare_index(self, costmap: Costmap, threads: int, check: Callable[[], None]) -> HubIndex:
        """Return the index of the map alone; of the first costmap, where it is not known what that is."""
        if costmap.changes is not None:
            alone = replace(costmap, data=costmap.changes.base, changes=None)
            prepared = self.prepared(alone, threads=threads, check=check)
            assert isinstance(prepared, HubIndex)
            return prepared
        if self._bare is None or self._bare[0].shape != costmap.data.shape:
            found = self._shared(costmap, check)
            if found is not None and (bare_free := found.free()).shape == costmap.data.shape:
                self._bare = bare_free, found
            else:
                free = self._free(costmap.data)
                self._bare = free, HubIndex(build_index(free, threads=threads, check=check))
        return self._bare[1]

    def _bare_free(self, costmap: Costmap) -> Free:
        if costmap.changes is not None:
            return self._free(costmap.changes.base)
        assert self._bare is not None
        return self._bare[0]

    def _only_closes(self, costmap: Costmap) -> bool:
        """Return whether all free cells are free on the map alone."""
        if costmap.changes is None:
            return not (self._free(costmap.data) & ~self._bare_free(costmap)).any()
        base, windows = costmap.changes
        unknown = self.allow_unknown
        return not any(opens(costmap.data, base, _bounds(window, base.shape), unknown) for window in windows)

    def _index_of(self, costmap: Costmap, bare: HubIndex, threads: int, check: Callable[[], None]) -> HubIndex:
        free = self._free(costmap.data)
        wanted = fingerprint(free)
        for index in (bare, self._repaired):
            if index is not None and index.is_of(wanted):
                return index
        changed = differing(self._bare_free(costmap), free)
        self._repaired = bare.repaired(free, changed, threads=threads, check=check)
        return self._repaired

    def _free(self, costs: NDArray[np.uint8]) -> Free:
        free: Free = costs < INSCRIBED_INFLATED_OBSTACLE
        if self.allow_unknown:
            free |= costs == NO_INFORMATION
        return free


def differing(bare_free: Free, now: Free) -> Rectangle:
    """Return the smallest rectangle that contains all differences of two maps."""
    changed = bare_free != now
    rows, columns = (np.flatnonzero(changed.any(axis=axis)) for axis in (1, 0))
    if not len(rows):
        return slice(0, 0), slice(0, 0)
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)


def _bounds(window: Window, shape: tuple[int, ...]) -> Bounds:
    (top, bottom, _), (left, right, _) = (part.indices(size) for part, size in zip(window, shape, strict=True))
    return top, bottom, left, right
