"""The graph of the corners of a map."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.hub_labels.building.kernels.contraction import TO
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.scan import Integers, scan_corners
from ppaas.planners.hub_labels.kernels.terrain import BLOCK, empty_terrain, lay, mend, number_corners

CELLS_A_SLICE = 1 << 19
CORNERS_A_SLICE = 1 << 11
WORK_A_SLICE = 1 << 17
"""How much is done between two calls of ``check``: about two milliseconds."""

FEW_SEEN = 8
"""Corners that a corner sees in the mean; a map is cluttered where they are fewer."""


@dataclass(frozen=True, slots=True)
class CornerMap:
    """A map as lines of bits, and the places of its corners.

    Parameters
    ----------
    terrain : int64 array
        As `kernels.terrain` has it.
    places : (n, 2) int32 array
        Row and column, with the margin.
    """

    terrain: Words
    places: Integers


Rectangle = tuple[slice, slice]
"""Rows and columns."""


@dataclass(frozen=True, slots=True)
class CornerGraph:
    """Which corners see each other: those that corner i sees are ``to[starts[i]:starts[i + 1]]``, so far away."""

    places: Integers
    starts: Words
    to: Integers
    lengths: Integers

    @property
    def is_cluttered(self) -> bool:
        """Tell whether corners see few others."""
        return len(self.to) < FEW_SEEN * (len(self.starts) - 1)


@dataclass(frozen=True, slots=True)
class ContractedGraph:
    """A contracted graph: linked lists of edges, as `kernels.contraction` has them, and the nodes in their order.

    An edge is in the list of the node from which it leads, unless that was contracted after the other one.
    """

    head: Integers
    after: Integers
    edges: Integers
    levels: Integers
    order: Integers

    def listed(self) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Return which edges are in a list, and which of them in that of a node that was contracted."""
        last = len(self.head)
        turns = np.full(last, last, np.int32)
        turns[self.order] = np.arange(len(self.order))
        to = turns[self.edges[:, TO]].reshape(-1, 2)
        origin = to[:, ::-1]
        return (to >= origin).ravel(), (to > origin).ravel()


def build_corner_map(free: NDArray[np.bool_], *, threads: int, check: Callable[[], None]) -> CornerMap:
    """Lay out the free cells of a map, (height, width)."""
    padded = np.pad(free, 1).view(np.uint8)
    rows, columns = padded.shape
    terrain = empty_terrain(rows, columns)
    slice_rows = max(BLOCK * threads, CELLS_A_SLICE // columns // BLOCK * BLOCK)
    for first in range(0, rows, slice_rows):
        check()
        lay(padded, terrain, first, min(first + slice_rows, rows), threads)
    return _with_places(terrain, check)


def repair_corner_map(
    terrain: Words, free: NDArray[np.bool_], changed: Rectangle, *, check: Callable[[], None]
) -> CornerMap:
    """Lay out a map anew of which only a rectangle differs from one that is laid out."""
    rows, columns = changed
    check()
    mended = terrain.copy()
    padded = np.pad(free, 1).view(np.uint8)
    height, width = free.shape
    # A cell's own neighbours tell what it is, and it lies one further in the array, for the margin.
    around = max(rows.start, 1), min(rows.stop + 2, height + 1), max(columns.start, 1), min(columns.stop + 2, width + 1)
    mend(padded, mended, *around)
    return _with_places(mended, check)


def _with_places(terrain: Words, check: Callable[[], None]) -> CornerMap:
    check()
    places = np.empty((number_corners(terrain, np.empty((0, 2), np.int32)), 2), np.int32)
    number_corners(terrain, places)
    terrain.flags.writeable = False
    return CornerMap(terrain, places)


def build_corner_graph(ground: CornerMap, *, threads: int, check: Callable[[], None]) -> CornerGraph:
    """Find which corners see each other."""
    corners = len(ground.places)
    starts, nothing = np.zeros(corners + 1, np.int64), np.empty(0, np.int32)

    def scan_all(to: Integers, lengths: Integers) -> None:
        for first in range(0, corners, CORNERS_A_SLICE):
            check()
            last = min(first + CORNERS_A_SLICE, corners)
            scan_corners(ground.terrain, ground.places, first, last, starts, to, lengths, threads)

    scan_all(nothing, nothing)
    np.cumsum(starts, out=starts)
    to, lengths = np.empty(starts[-1], np.int32), np.empty(starts[-1], np.int32)
    if len(to):
        scan_all(to, lengths)
    return CornerGraph(ground.places, starts, to, lengths)
