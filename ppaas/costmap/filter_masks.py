"""Masks of costmap filters as layers of a map: where robots are to keep out, and how fast they may drive.

Cells of masks mean what they mean to Nav2's costmap filters.
"""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import LETHAL_OBSTACLE, NO_INFORMATION
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN, GridInfo, GridMap

_BLOCK = 1 << 18
"""Cells that are looked up at a time."""

# What a cell costs by the byte of its value: 0 to 100 scaled to lethal and rounded; what is unknown says nothing.
_COSTS = np.zeros(256, np.uint8)
_COSTS[: OCCUPIED + 1] = (np.arange(OCCUPIED + 1) * LETHAL_OBSTACLE + OCCUPIED // 2) // OCCUPIED


def sampled(mask: GridMap, info: GridInfo) -> GridMap:
    """Return a mask by the cells of a map: each says what the mask says at its middle, unknown beyond the mask.

    Parameters
    ----------
    mask : GridMap
        Of any resolution and origin, in the frame of the map.
    info : GridInfo
        Of the map.
    """
    data = np.full(info.shape, UNKNOWN, np.int8)
    for block, rows, columns in _cells_of(info, mask.info):
        inside = _within(rows, columns, mask.info)
        data[block][inside] = mask.data[rows[inside].astype(np.int64), columns[inside].astype(np.int64)]
    return GridMap(data, info)


def spread(mask: GridMap, info: GridInfo) -> GridMap:
    """Return a keep-out mask by the cells of a map, so that nothing is lost where its own cells are smaller.

    A cell of the map has the highest value of those cells of the mask whose middle lies in it, and of the one in which
    its own middle lies; 0 where that is unknown or there is none.

    Parameters
    ----------
    mask : GridMap
        Of any resolution and origin, in the frame of the map.
    info : GridInfo
        Of the map.
    """
    data = np.maximum(sampled(mask, info).data, FREE).astype(np.int8)
    for block, rows, columns in _cells_of(mask.info, info):
        told = _within(rows, columns, info) & (mask.data[block] > FREE)
        cells = (rows[told] * info.width + columns[told]).astype(np.int64)
        np.maximum.at(data.reshape(-1), cells, mask.data[block][told])
    return GridMap(data, info)


def barred(grid: GridMap, keepout: GridMap) -> GridMap:
    """Return a map in which cells to keep out of are occupied, too; both are of the same cells."""
    return GridMap(np.where(keepout.data == OCCUPIED, np.int8(OCCUPIED), grid.data), grid.info)


def raise_costs(costs: NDArray[np.uint8], keepout: NDArray[np.int8]) -> None:
    """Raise costs to what a keep-out mask says, in place.

    Parameters
    ----------
    costs : (height, width) uint8 array
        Values of costmap_2d; written to. What is unknown has a cost where the mask gives it one.
    keepout : (height, width) int8 array
        Of the same cells: 100 is lethal, 1 to 99 cost 2.54 times as much, 0 and −1 say nothing.
    """
    said = _COSTS[keepout.view(np.uint8)]
    np.copyto(costs, said, where=(said > 0) & ((costs == NO_INFORMATION) | (costs < said)))


def _within(rows: NDArray[np.float64], columns: NDArray[np.float64], info: GridInfo) -> NDArray[np.bool_]:
    inside: NDArray[np.bool_] = (rows >= 0) & (rows < info.height) & (columns >= 0) & (columns < info.width)
    return inside


def _cells_of(info: GridInfo, other: GridInfo) -> Iterator[tuple[slice, NDArray[np.float64], NDArray[np.float64]]]:
    """Yield rows of a grid, some at a time, with row and column in another grid of the middles of their cells.

    They are whole numbers, but may lie farther away than integers reach.
    """
    frame = other.origin.inverse() @ info.origin
    c, s = math.cos(frame.theta), math.sin(frame.theta)
    x = (np.arange(info.width) + 0.5) * info.resolution
    step = max(_BLOCK // info.width, 1)
    for start in range(0, info.height, step):
        block = slice(start, min(start + step, info.height))
        y = (np.arange(block.start, block.stop)[:, None] + 0.5) * info.resolution
        columns = np.floor((frame.x + c * x - s * y) / other.resolution)
        rows = np.floor((frame.y + s * x + c * y) / other.resolution)
        yield block, rows, columns
