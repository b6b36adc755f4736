"""Slow, obvious twins of the masks of costmap filters, and of the height mask of a map in space."""

import numpy as np
from numpy.typing import NDArray

from ppaas.maps.grid import GridInfo, GridMap
from ppaas.maps.voxels import VoxelGrid


def sampled(mask: GridMap, info: GridInfo) -> NDArray[np.int8]:
    """Return the value of a mask at the centre of each cell, −1 outside the mask."""
    found = np.full(info.shape, -1, np.int8)
    for cell in np.ndindex(info.shape):
        there = mask.info.cell_of(*info.to_world(cell).tolist())
        if there is not None:
            found[cell] = mask.data[there]
    return found


def spread(mask: GridMap, info: GridInfo) -> NDArray[np.int8]:
    """Return the highest value at the centre of each cell and of the mask cells whose centres are in it."""
    found = np.maximum(sampled(mask, info), 0)
    for cell in np.ndindex(mask.info.shape):
        there = info.cell_of(*mask.info.to_world(cell).tolist())
        if there is not None:
            found[there] = max(found[there], mask.data[cell])
    return found


def cost(value: int) -> int:
    """Return the cost of a mask's value from 0 to 100: scaled to 254, with halves rounded up."""
    return int(254 * value / 100 + 0.5)


def height_mask(voxels: VoxelGrid, info: GridInfo, lowest: float, highest: float) -> NDArray[np.int8]:
    """Return 100 in cells that an occupied voxel overlaps within a range of heights; both grids are axis-aligned."""
    found = np.zeros(info.shape, np.int8)
    edge = voxels.info.resolution
    corners = info.to_world(np.moveaxis(np.indices(info.shape), 0, -1)) - info.resolution / 2
    left, bottom = corners[..., 0], corners[..., 1]
    for layer, row, column in np.argwhere(voxels.data == 100).tolist():
        x, y, z = voxels.info.to_world((layer, row, column)) - edge / 2
        if z + edge <= lowest + 1e-9 or z >= highest - 1e-9:
            continue
        beside = np.minimum(x + edge, left + info.resolution) - np.maximum(x, left)
        behind = np.minimum(y + edge, bottom + info.resolution) - np.maximum(y, bottom)
        found[np.minimum(beside, behind) > 1e-9] = 100
    return found
