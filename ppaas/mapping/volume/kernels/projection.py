"""Kernel: projection of a volume onto a 2D occupancy grid, as in ``octomap_server``."""

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.mapping.volume.kernels.blocks import BITS, EDGE, EMPTY, VOXELS, entry_of
from ppaas.mapping.volume.kernels.ends import MIDDLE

_FREE, _OCCUPIED = np.int8(0), np.int8(100)

Words = NDArray[np.int64]


@compiled
def _has_neighbour(codes: Words, slots: Words, log_odds: NDArray[np.float32], x: int, y: int, z: int) -> bool:
    """Return whether any of the 26 voxels around a voxel is occupied."""
    for dz in range(-1, 2):
        for dy in range(-1, 2):
            for dx in range(-1, 2):
                nx, ny, nz = x + dx, y + dy, z + dz
                if (dx == 0 and dy == 0 and dz == 0) or min(nx, ny, nz) < 0 or max(nx, ny, nz) >= 2 * MIDDLE:
                    continue
                entry = entry_of(codes, (nz // EDGE) << 2 * BITS | (ny // EDGE) << BITS | nx // EDGE)
                voxel = (nz % EDGE * EDGE + ny % EDGE) * EDGE + nx % EDGE
                if codes[entry] != EMPTY and log_odds[slots[entry], voxel] >= 0.0:
                    return True
    return False


@compiled
def project(
    codes: Words,
    slots: Words,
    log_odds: NDArray[np.float32],
    corners: Words,
    layers: tuple[int, int],
    speckles: bool,
    first: tuple[int, int],
    cells: NDArray[np.int8],
) -> None:
    """Set the cells below occupied voxels to 100, and the others below free voxels to 0.

    Parameters
    ----------
    codes, slots : (2^k,) int64 array
        Table of the blocks, see `ppaas.mapping.volume.kernels.blocks`.
    log_odds : (n, 512) float32 array
        Log-odds of the voxels, NaN where unknown.
    corners : (n, 3) int64 array
        Least keys of the blocks x, y, z, in the order of their slots.
    layers : tuple of two int
        Keys along z: the first that counts, and the one after the last.
    speckles : bool
        Whether an occupied voxel without an occupied neighbour counts.
    first : tuple of two int
        Keys of cell (0, 0) along x and y.
    cells : (height, width) int8 array
        Modified: the grid, which holds all blocks.
    """
    for slot in range(len(corners)):
        x0, y0, z0 = corners[slot]
        for voxel in range(VOXELS):
            value = log_odds[slot, voxel]
            z = z0 + voxel // (EDGE * EDGE)
            if np.isnan(value) or z < layers[0] or z >= layers[1]:
                continue
            x, y = x0 + voxel % EDGE, y0 + voxel // EDGE % EDGE
            row, column = y - first[1], x - first[0]
            if value < 0.0:
                cells[row, column] = max(cells[row, column], _FREE)
            elif speckles or _has_neighbour(codes, slots, log_odds, x, y, z):
                cells[row, column] = _OCCUPIED


def warm() -> None:
    """Call the kernel once, so that it is compiled or loaded from the cache."""
    codes, slots, corners = np.full(2, EMPTY), np.zeros(2, np.int64), np.zeros((1, 3), np.int64)
    log_odds = np.full((1, VOXELS), np.nan, np.float32)
    project(codes, slots, log_odds, corners, (0, 8), False, (0, 0), np.zeros((8, 8), np.int8))
