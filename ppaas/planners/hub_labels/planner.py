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
from ppaas.planners.hub_labels.building.assembly import build_index, repair_index
from ppaas.planners.hub_labels.building.graph import Rectangle
from ppaas.planners.hub_labels.building.header import fingerprint, unseal
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.free_path import Bounds, is_free_along, opens
from ppaas.planners.hub_labels.kernels.layout import FINGERPRINT, TERRAIN
from ppaas.planners.hub_labels.kernels.query import entry
from ppaas.planners.hub_labels.kernels.scratch import EXPANDED, new_scratch
from ppaas.planners.hub_labels.kernels.terrain import COLUMNS, ROWS, free_cells
from ppaas.planners.prepared import Prepared, PreparedPlanner
from ppaas.planners.traits import Optimal, Traits
from ppaas.planners.watch import proceed

# -- the index of a map, and queries on it -----------------------------------------------------------------------------


class HubIndex(Prepared):
    """An index, together with the scratch memory of its queries.

    Parameters
    ----------
    words : int64 array
        The index, laid out as `kernels.layout` describes; read-only.
    """

    def __init__(self, words: Words) -> None:
        self.words = words
        self._scratch = new_scratch(words)
        self._find = entry()

    @property
    def nbytes(self) -> int:
        """Size of the index [bytes]. All users share it."""
        return self.words.nbytes

    @property
    def expanded(self) -> int:  # type: ignore[override]  # counted by the kernel, read on demand
        """Number of label entries that the last query examined."""
        return int(self._scratch[EXPANDED])

    def path(
        self, start_row: int, start_column: int, goal_row: int, goal_column: int, check: Callable[[], None] = proceed
    ) -> NDArray[np.int32]:
        """Return the (n, 2) cells of a shortest path; empty if there is none, or an end is not free."""
        return self._find(self.words, self._scratch, start_row, start_column, goal_row, goal_column)

    def free(self) -> NDArray[np.bool_]:
        """Return a mask of the free cells of its map, (height, width)."""
        terrain = self.words[self.words[TERRAIN] : self.words[TERRAIN + 1]]
        free = np.empty((int(terrain[ROWS]) - 2, int(terrain[COLUMNS]) - 2), np.uint8)
        free_cells(terrain, free)
        return free.view(np.bool_)

    def is_of(self, expected: Words) -> bool:
        """Return whether it is the index of the map with this fingerprint."""
        return bool((self.words[FINGERPRINT : FINGERPRINT + len(expected)] == expected).all())

    def repaired(
        self, free: NDArray[np.bool_], changed: Rectangle, *, threads: int = 1, check: Callable[[], None] = proceed
    ) -> "HubIndex":
        """Return the index of a map that differs only in a rectangle; faster than building a new one.

        Parameters
        ----------
        free : (height, width) bool array
            Free cells of the current map.
        changed : (slice, slice)
            Rows and columns that contain all changes.
        threads : int
            Maximum number of threads for kernels.
        check : callable
            Called at least every 10 ms of work; may raise to cancel it.

        Raises
        ------
        InvalidPlanner
            The map is too large or too cluttered for an index.
        """
        return HubIndex(repair_index(self.words, free, changed, threads=threads, check=check))

    def twin(self) -> "HubIndex":
        """Return an index for another thread: the same words with its own scratch memory."""
        return HubIndex(self.words)


# -- the planner -------------------------------------------------------------------------------------------------------

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
