"""The index of a map, and queries on it."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.hub_labels.building.assembly import repair_index
from ppaas.planners.hub_labels.building.graph import Rectangle
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.layout import FINGERPRINT, TERRAIN
from ppaas.planners.hub_labels.kernels.query import entry
from ppaas.planners.hub_labels.kernels.scratch import EXPANDED, new_scratch
from ppaas.planners.hub_labels.kernels.terrain import COLUMNS, ROWS, free_cells
from ppaas.planners.prepared import Prepared
from ppaas.planners.watch import proceed


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
