"""Frontiers of a map: the free cells beside unknown ones, joined to components.

Source: B. Yamauchi, "A frontier-based approach for autonomous exploration", CIRA 1997.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.graph.kernels.edges import connected_parts
from ppaas.maps.grid import FREE, OCCUPIED_THRESHOLD, UNKNOWN, GridMap

Cells = NDArray[np.int64]

_SIDES = ((-1, 0), (1, 0), (0, -1), (0, 1))


@dataclass(frozen=True, slots=True)
class Frontier:
    """Free cells beside unknown ones; each touches another of them at a side or a corner.

    Parameters
    ----------
    cells : (n, 2) int64 array
        Row, column; sorted.
    size : float
        Number of cells times their edge [m].
    heading : float
        Mean direction from the cells into the unknown, in the map frame [rad].
    """

    cells: Cells
    size: float
    heading: float


def beside_unknown(grid: GridMap) -> NDArray[np.bool_]:
    """Return the (h, w) mask of the free cells with an unknown cell at one of their four sides.

    What is outside the grid is not known to be unknown: a map may end at a wall.
    """
    unknown = grid.data == UNKNOWN
    near = np.zeros(grid.info.shape, np.bool_)
    near[1:] |= unknown[:-1]
    near[:-1] |= unknown[1:]
    near[:, 1:] |= unknown[:, :-1]
    near[:, :-1] |= unknown[:, 1:]
    return near & (grid.data >= FREE) & (grid.data < OCCUPIED_THRESHOLD)


def find_frontiers(grid: GridMap, smallest: float = 0.0) -> list[Frontier]:
    """Return the frontiers of a map, the largest first.

    Parameters
    ----------
    grid : GridMap
        The map.
    smallest : float
        Smaller frontiers are left out [m].
    """
    cells = np.argwhere(beside_unknown(grid))
    parts = _parts(cells, grid.info.width)
    order = np.argsort(parts, kind="stable")
    bounds = np.flatnonzero(np.diff(parts[order], prepend=-1))
    groups = np.split(cells[order], bounds[1:]) if len(cells) else []
    least = smallest / grid.info.resolution - 1e-9
    kept = sorted((group for group in groups if len(group) >= least), key=len, reverse=True)
    return [Frontier(group, len(group) * grid.info.resolution, _heading(grid, group)) for group in kept]


def known_area(grid: GridMap) -> float:
    """Return the area of the free and occupied cells [m²]."""
    return int(np.count_nonzero(grid.data != UNKNOWN)) * grid.info.resolution**2


def _parts(cells: Cells, width: int) -> Cells:
    """Return for each of the (n, 2) sorted cells the index of the first one in its component."""
    stride = width + 2
    keys = cells[:, 0] * stride + cells[:, 1]
    first, second = [], []
    for step in (1, stride - 1, stride, stride + 1):
        at = np.searchsorted(keys, keys + step)
        at[at == len(keys)] = 0
        touching = np.flatnonzero(keys[at] == keys + step) if len(keys) else at
        first.append(touching)
        second.append(at[touching])
    parts: Cells = connected_parts(len(keys), np.concatenate(first), np.concatenate(second))
    return parts


def _heading(grid: GridMap, cells: Cells) -> float:
    """Return the mean direction from cells to their unknown neighbours; 0 if they cancel out [rad]."""
    down = right = 0
    for row, column in _SIDES:
        near = cells + np.array((row, column))
        inside = ((near >= 0) & (near < grid.info.shape)).all(axis=1)
        count = int(np.count_nonzero(grid.data[near[inside, 0], near[inside, 1]] == UNKNOWN))
        down, right = down + row * count, right + column * count
    return math.atan2(down, right) + grid.info.origin.theta
