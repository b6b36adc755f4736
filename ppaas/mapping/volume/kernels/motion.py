"""Kernel: blocks of voxels turned about z and moved, sampled anew on the lattice of the map.

Each new voxel has the log-odds of the old voxel in which its centre was. So nothing has holes, and a wall stays as
thick as it was.
"""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.mapping.volume.kernels.blocks import BITS, EDGE, EMPTY, VOXELS, entry_of
from ppaas.mapping.volume.kernels.ends import MIDDLE

Words = NDArray[np.int64]


@compiled
def sample_moved(
    codes: Words,
    slots: Words,
    log_odds: NDArray[np.float32],
    wanted: Words,
    back: tuple[float, float, float, float],
    sampled: NDArray[np.float32],
) -> None:
    """Find the log-odds of new blocks.

    Parameters
    ----------
    codes, slots : (2^k,) int64 array
        Table of the old blocks, see `ppaas.mapping.volume.kernels.blocks`.
    log_odds : (slots, 512) float32 array
        Log-odds of the old voxels, NaN where unknown.
    wanted : (n,) int64 array
        Codes of the new blocks.
    back : tuple of four float
        Motion from the new to the old place: cosine and sine of its angle, and its translation along x and y [voxels].
    sampled : (n, 512) float32 array
        In: NaN. Out: log-odds of the new voxels.
    """
    c, s, tx, ty = back
    mask = (1 << BITS) - 1
    for i in range(len(wanted)):
        x0, y0 = (wanted[i] & mask) * EDGE - MIDDLE, (wanted[i] >> BITS & mask) * EDGE - MIDDLE
        layer = wanted[i] >> 2 * BITS << 2 * BITS
        last, slot = EMPTY, -1
        for column in range(EDGE * EDGE):
            x, y = x0 + column % EDGE + 0.5, y0 + column // EDGE + 0.5
            kx, ky = math.floor(c * x - s * y + tx) + MIDDLE, math.floor(s * x + c * y + ty) + MIDDLE
            if min(kx, ky) < 0 or max(kx, ky) >= 2 * MIDDLE:
                continue
            code = layer | (ky // EDGE) << BITS | kx // EDGE
            if code != last:
                entry = entry_of(codes, code)
                last, slot = code, int(slots[entry]) if codes[entry] != EMPTY else -1
            if slot < 0:
                continue
            voxel = ky % EDGE * EDGE + kx % EDGE
            for z in range(EDGE):
                sampled[i, z * EDGE * EDGE + column] = log_odds[slot, z * EDGE * EDGE + voxel]


def warm() -> None:
    """Call the kernel once, so that it is compiled or loaded from the cache."""
    codes, slots, wanted = np.full(2, EMPTY), np.zeros(2, np.int64), np.zeros(1, np.int64)
    log_odds = np.full((1, VOXELS), np.nan, np.float32)
    sample_moved(codes, slots, log_odds, wanted, (1.0, 0.0, 0.0, 0.0), log_odds.copy())
