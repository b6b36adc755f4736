"""The corners of a map, and the graph of which corners see each other (subgoal graph)."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.hub_labels.building.kernels.contraction import TO
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.scan import Integers, scan_corners
from ppaas.planners.hub_labels.kernels.terrain import (
    BLOCK,
    empty_terrain,
    number_corners,
    rewrite_rectangle,
    write_lines,
)

CELLS_A_SLICE = 1 << 19
"""Cells processed between two calls of ``check``."""

CORNERS_A_SLICE = 1 << 11
"""Corners processed between two calls of ``check``."""

WORK_A_SLICE = 1 << 17
"""Work between two calls of ``check``: about two milliseconds."""

FEW_SEEN = 8
"""Mean number of corners seen by a corner below which a map is cluttered."""


@dataclass(frozen=True, slots=True)
class CornerMap:
    """A map as lines of bits, and its corners.

    Parameters
    ----------
    terrain : int64 array
        The map as lines of bits, laid out as `kernels.terrain` describes.
    positions : (n, 2) int32 array
        Row and column of each corner, including the margin.
    """

    terrain: Words
    positions: Integers


Rectangle = tuple[slice, slice]
"""Rows and columns."""


@dataclass(frozen=True, slots=True)
class CornerGraph:
    """Graph of corners that see each other.

    Parameters
    ----------
    positions : (n, 2) int32 array
        Row and column of each corner.
    starts : (n + 1,) int64 array
        Corner i sees the corners ``to[starts[i]:starts[i + 1]]``.
    to, lengths : (m,) int32 arrays
        Corners, and their distances.
    """

    positions: Integers
    starts: Words
    to: Integers
    lengths: Integers

    @property
    def is_cluttered(self) -> bool:
        """Whether corners see few other corners."""
        return len(self.to) < FEW_SEEN * (len(self.starts) - 1)


@dataclass(frozen=True, slots=True)
class ContractedGraph:
    """A contracted graph as linked lists of edges.

    Each pair of edges is listed at the node that was contracted first. Edges between core nodes are listed at both
    ends.

    Parameters
    ----------
    head : (n,) int32 array
        First edge of each node, or −1.
    after : (m,) int32 array
        Next edge of the same node, or −1.
    edges : (m, 5) int32 array
        Edges, as in `kernels.contraction`.
    levels : (n,) int32 array
        Contraction level of each node.
    order : int32 array
        Contracted nodes, in their order.
    """

    head: Integers
    after: Integers
    edges: Integers
    levels: Integers
    order: Integers

    def listed(self) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Return a mask of the listed edges, and one of those that are listed at a contracted node."""
        last = len(self.head)
        turns = np.full(last, last, np.int32)
        turns[self.order] = np.arange(len(self.order))
        to = turns[self.edges[:, TO]].reshape(-1, 2)
        origin = to[:, ::-1]
        return (to >= origin).ravel(), (to > origin).ravel()


def build_corner_map(free: NDArray[np.bool_], *, threads: int, check: Callable[[], None]) -> CornerMap:
    """Return the corner map of the free cells of a map, (height, width)."""
    padded = np.pad(free, 1).view(np.uint8)
    rows, columns = padded.shape
    terrain = empty_terrain(rows, columns)
    slice_rows = max(BLOCK * threads, CELLS_A_SLICE // columns // BLOCK * BLOCK)
    for first in range(0, rows, slice_rows):
        check()
        write_lines(padded, terrain, first, min(first + slice_rows, rows), threads)
    return _with_corners(terrain, check)


def repair_corner_map(
    terrain: Words, free: NDArray[np.bool_], changed: Rectangle, *, check: Callable[[], None]
) -> CornerMap:
    """Return the corner map of a map that differs only in a rectangle from the one with this ``terrain``."""
    rows, columns = changed
    check()
    repaired = terrain.copy()
    padded = np.pad(free, 1).view(np.uint8)
    height, width = free.shape
    # Whether a cell is a corner depends on its neighbours. Indices include the margin of one cell.
    around = max(rows.start, 1), min(rows.stop + 2, height + 1), max(columns.start, 1), min(columns.stop + 2, width + 1)
    rewrite_rectangle(padded, repaired, *around)
    return _with_corners(repaired, check)


def _with_corners(terrain: Words, check: Callable[[], None]) -> CornerMap:
    check()
    positions = np.empty((number_corners(terrain, np.empty((0, 2), np.int32)), 2), np.int32)
    number_corners(terrain, positions)
    terrain.flags.writeable = False
    return CornerMap(terrain, positions)


def build_corner_graph(corner_map: CornerMap, *, threads: int, check: Callable[[], None]) -> CornerGraph:
    """Return the graph of corners that see each other."""
    corners = len(corner_map.positions)
    starts, nothing = np.zeros(corners + 1, np.int64), np.empty(0, np.int32)

    def scan_all(to: Integers, lengths: Integers) -> None:
        for first in range(0, corners, CORNERS_A_SLICE):
            check()
            last = min(first + CORNERS_A_SLICE, corners)
            scan_corners(corner_map.terrain, corner_map.positions, first, last, starts, to, lengths, threads)

    scan_all(nothing, nothing)
    np.cumsum(starts, out=starts)
    to, lengths = np.empty(starts[-1], np.int32), np.empty(starts[-1], np.int32)
    if len(to):
        scan_all(to, lengths)
    return CornerGraph(corner_map.positions, starts, to, lengths)
