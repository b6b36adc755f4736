"""Masks of costmap filters: keep-out zones and speed limits on the cells of a map, and obstacles at a robot's heights.

The values of masks have the meaning of Nav2's costmap filters.
"""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import LETHAL_OBSTACLE, NO_INFORMATION
from ppaas.geometry import Pose2D
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN, GridInfo, GridMap
from ppaas.maps.kernels.octree import fill_cubes
from ppaas.maps.octree import DEPTH, MIDDLE, OcTree, edges

_BLOCK = 1 << 18
"""Number of cells that are resampled at once."""

# Cost of a mask's value, indexed by its byte: 0 to 100 scaled to 0 to 254 and rounded; unknown has no cost.
_COSTS = np.zeros(256, np.uint8)
_COSTS[: OCCUPIED + 1] = (np.arange(OCCUPIED + 1) * LETHAL_OBSTACLE + OCCUPIED // 2) // OCCUPIED


def sampled(mask: GridMap, info: GridInfo) -> GridMap:
    """Return a mask resampled to the cells of a map: its value at the centre of each cell, unknown outside the mask.

    Parameters
    ----------
    mask : GridMap
        Mask of any resolution and origin, in the frame of the map.
    info : GridInfo
        Geometry of the map.
    """
    data = np.full(info.shape, UNKNOWN, np.int8)
    for block, rows, columns in _cells_of(info, mask.info):
        inside = _within(rows, columns, mask.info)
        data[block][inside] = mask.data[rows[inside].astype(np.int64), columns[inside].astype(np.int64)]
    return GridMap(data, info)


def spread(mask: GridMap, info: GridInfo) -> GridMap:
    """Return a keep-out mask resampled to the cells of a map, so that small zones of a finer mask are not lost.

    A cell of the map gets the highest value of the mask cells with a centre in it, and of the mask cell that contains
    its own centre; 0 where these are unknown or missing.

    Parameters
    ----------
    mask : GridMap
        Mask of any resolution and origin, in the frame of the map.
    info : GridInfo
        Geometry of the map.
    """
    data = np.maximum(sampled(mask, info).data, FREE).astype(np.int8)
    for block, rows, columns in _cells_of(mask.info, info):
        used = _within(rows, columns, info) & (mask.data[block] > FREE)
        cells = (rows[used] * info.width + columns[used]).astype(np.int64)
        np.maximum.at(data.reshape(-1), cells, mask.data[block][used])
    return GridMap(data, info)


def barred(grid: GridMap, keepout: GridMap) -> GridMap:
    """Return a map in which cells of 100 in a keep-out mask are occupied as well; both have the same cells."""
    return GridMap(np.where(keepout.data == OCCUPIED, np.int8(OCCUPIED), grid.data), grid.info)


def raise_costs(costs: NDArray[np.uint8], keepout: NDArray[np.int8]) -> None:
    """Raise costs to a keep-out mask's costs, in place.

    Parameters
    ----------
    costs : (height, width) uint8 array
        Values of costmap_2d; modified. Unknown cells get the cost of the mask if it is above 0.
    keepout : (height, width) int8 array
        Mask of the same cells: 100 is lethal (254), 1 to 99 cost 2.54 times their value, 0 and −1 have no effect.
    """
    mask_costs = _COSTS[keepout.view(np.uint8)]
    np.copyto(costs, mask_costs, where=(mask_costs > 0) & ((costs == NO_INFORMATION) | (costs < mask_costs)))


def _within(rows: NDArray[np.float64], columns: NDArray[np.float64], info: GridInfo) -> NDArray[np.bool_]:
    inside: NDArray[np.bool_] = (rows >= 0) & (rows < info.height) & (columns >= 0) & (columns < info.width)
    return inside


def _cells_of(info: GridInfo, other: GridInfo) -> Iterator[tuple[slice, NDArray[np.float64], NDArray[np.float64]]]:
    """Yield blocks of a grid's rows, with the row and column in another grid of the centres of their cells.

    Rows and columns are whole numbers in float64, since they may exceed the range of int64.
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


# -- obstacles of a map in space at the heights of a robot -------------------------------------------------------------

_SLACK = 1e-6
"""Tolerance for rounded heights, so that touching does not count as overlap [voxels]."""


def height_mask(tree: OcTree, info: GridInfo, *, lowest: float | None, highest: float) -> GridMap:
    """Return a mask that is 100 where an occupied voxel overlaps the heights of a robot, and 0 elsewhere.

    Parameters
    ----------
    tree : OcTree
        Map in space, in the frame of the map, whose floor is at z = 0. Unknown space does not count.
    info : GridInfo
        Geometry of the map; the mask covers its extent.
    lowest, highest : float
        Range of heights in which occupied voxels count [m]. The default of ``lowest`` is the edge of one voxel of the
        octree, since the floor of a map is that rough.

    Returns
    -------
    GridMap
        Mask whose cells are columns of the octree: of the coarsest depth whose voxels are at most as wide as a cell of
        the map, or else of the finest depth.
    """
    levels = math.floor(math.log2(info.resolution) - math.log2(tree.resolution) + _SLACK)
    size = 1 << min(max(levels, 0), DEPTH)  # width of a column [finest voxels]
    columns = _columns(info, size * tree.resolution, MIDDLE // size)
    first = np.rint(np.array(columns.origin[:2]) / columns.resolution).astype(np.int64)
    slack = _SLACK * tree.resolution
    keys = tree.corners[tree.occupied].astype(np.int64) - MIDDLE
    widths = edges(tree.depths[tree.occupied])
    bottom, top = keys[:, 2] * tree.resolution, (keys[:, 2] + widths) * tree.resolution
    floor = tree.resolution if lowest is None else lowest
    hit = (top > floor + slack) & (bottom < highest - slack)
    begins = np.zeros((int(hit.sum()), 3), np.int64)
    begins[:, :2] = keys[hit, :2] // size - first
    data = np.zeros(columns.shape, np.uint8)
    fill_cubes(data[None], begins, np.maximum(widths[hit] // size, 1), np.full(len(begins), OCCUPIED, np.uint8))
    return GridMap(data.view(np.int8), columns)


def _columns(info: GridInfo, width: float, reach: int) -> GridInfo:
    """Return the grid of columns that covers a map.

    Parameters
    ----------
    info : GridInfo
        Geometry of the map.
    width : float
        Width of a column [m]; columns begin at multiples of it.
    reach : int
        Number of columns that the octree has from 0 m to each side, which limits the grid.
    """
    far = info.width * info.resolution, info.height * info.resolution
    ends = [(info.origin @ Pose2D(x, y))[:2] for x in (0.0, far[0]) for y in (0.0, far[1])]
    low = np.clip(np.floor(np.min(ends, axis=0) / width), -reach, reach).astype(np.int64)
    high = np.clip(np.ceil(np.max(ends, axis=0) / width), -reach, reach).astype(np.int64)
    columns, rows = np.maximum(high - low, 1).tolist()
    return GridInfo(width, columns, rows, Pose2D(*(low * width).tolist()))
