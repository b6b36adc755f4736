"""Kernel: leaves of the octree of a volume, merged as in OctoMap's ``pruneNode``."""

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.mapping.volume.kernels.blocks import VOXELS

DEPTH = 16
"""Depth of the finest voxels."""


@compiled(inline="always")
def _siblings(corners: NDArray[np.uint16], depths: NDArray[np.uint8], values: NDArray[np.float32], count: int) -> bool:
    """Return whether the last eight leaves are the children of one node, not of the root, and equal."""
    first, last = count - 8, count - 1
    depth = depths[last]
    if first < 0 or depth < 2:
        return False
    edge = 1 << (DEPTH - depth)
    for axis in range(3):
        low, high = np.int64(corners[first, axis]), np.int64(corners[last, axis])
        if high & edge == 0 or low != high - edge:
            return False
    equal = True
    for leaf in range(first, last):
        equal &= (depths[leaf] == depth) & (values[leaf] == values[last])
    return equal


@compiled
def merge_leaves(
    blocks: NDArray[np.int64],
    slots: NDArray[np.int64],
    order: NDArray[np.int64],
    log_odds: NDArray[np.float32],
    by_occupancy: bool,
    corners: NDArray[np.uint16],
    depths: NDArray[np.uint8],
    values: NDArray[np.float32],
) -> int:
    """Find the leaves of the octree in depth-first order; return their number.

    Voxels are appended in that order. Whenever the last eight leaves are equal siblings, their parent replaces them.

    Parameters
    ----------
    blocks : (n, 3) int64 array
        Least keys of the blocks (x, y, z), in depth-first order.
    slots : (n,) int64 array
        Slots of the blocks.
    order : (512,) int64 array
        Voxels of a block in depth-first order.
    log_odds : (slots, 512) float32 array
        Log-odds of the voxels, NaN where unknown.
    by_occupancy : bool
        Whether leaves are equal if both or neither are occupied, and have the value 1 or −1; else by log-odds.
    corners : (m, 3) uint16 array
        Out: least keys of the leaves; m is at least the number of known voxels.
    depths : (m,) uint8 array
        Out: depths of the leaves.
    values : (m,) float32 array
        Out: values of the leaves.
    """
    count = 0
    for i in range(len(blocks)):
        for voxel in order:
            value = log_odds[slots[i], voxel]
            if np.isnan(value):
                continue
            if by_occupancy:
                value = np.float32(1.0) if value >= 0.0 else np.float32(-1.0)
            corners[count, 0] = blocks[i, 0] + (voxel & 7)
            corners[count, 1] = blocks[i, 1] + (voxel >> 3 & 7)
            corners[count, 2] = blocks[i, 2] + (voxel >> 6)
            depths[count], values[count] = DEPTH, value
            count += 1
            while _siblings(corners, depths, values, count):
                count -= 7
                depths[count - 1] -= 1
    return count


def warm() -> None:
    """Call the kernel once, so that it is compiled or loaded from the cache."""
    zero, one = np.zeros(1, np.int64), np.zeros(1, np.uint8)
    log_odds, values = np.full((1, VOXELS), np.nan, np.float32), np.zeros(1, np.float32)
    merge_leaves(np.zeros((1, 3), np.int64), zero, zero, log_odds, True, np.zeros((1, 3), np.uint16), one, values)
