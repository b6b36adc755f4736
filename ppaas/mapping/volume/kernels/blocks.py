"""Kernels: blocks of 8 × 8 × 8 voxels in a hash table, and their update with the bits of a scan.

Block (bx, by, bz) holds the voxels of the keys 8 · bx to 8 · bx + 7 and so on; its code is bz · 2²⁶ + by · 2¹³ + bx.
The table is an array of codes with open addressing (−1 where empty) and the array of their slots. The slot of a block
is its row in the array of log-odds, in which voxel (x, y, z) of the block is at 64 · z + 8 · y + x; NaN means unknown.
"""

from collections.abc import Callable

import numpy as np
from numba import prange
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.maps.kernels.serial import serial_copy

EDGE = 8
"""Edge of a block [voxels]."""

VOXELS = EDGE**3
"""Number of voxels of a block."""

BITS = 13
"""Bits of the code of a block per axis."""

EMPTY = -1
"""Code of an empty entry of the table."""

_FIBONACCI = np.int64(-7046029254386353131)
"""2⁶⁴ divided by the golden ratio, as a signed number."""

Words = NDArray[np.int64]
Collect = Callable[[Words, Words, Words, NDArray[np.uint8]], None]
Update = Callable[
    [
        NDArray[np.uint8], NDArray[np.uint8], Words, Words, Words, NDArray[np.float32],
        tuple[np.float32, np.float32, np.float32, np.float32],
    ],
    None,
]  # fmt: skip


def _collect(free: Words, occupied: Words, box: Words, touched: NDArray[np.uint8]) -> None:
    """Join the bits of all parts in the first one, let occupied voxels win, and find the blocks that have bits.

    Parameters
    ----------
    free, occupied : (parts, words) int64 array
        Modified: bits of the box, see `ppaas.mapping.volume.kernels.rays`. Those of all parts but the first become 0.
    box : (6,) int64 array
        Keys of the least voxel of the box, and its size W, H, D [voxels].
    touched : (D / 8, H / 8, W / 8) uint8 array
        In: zeros. Out: 1 for blocks with bits.
    """
    height, row = box[4], box[3] >> 6
    for layer in prange(box[5] // EDGE):
        for i in range(layer * EDGE * height, (layer + 1) * EDGE * height):
            y = (i % height) // EDGE
            for word in range(row):
                at = i * row + word
                passed, ended = free[0, at], occupied[0, at]
                for part in range(1, len(free)):
                    passed |= free[part, at]
                    ended |= occupied[part, at]
                    free[part, at] = occupied[part, at] = 0
                if passed | ended == 0:
                    continue
                free[0, at], occupied[0, at] = passed & ~ended, ended
                for block in range(EDGE):
                    if (passed | ended) >> (EDGE * block) & 0xFF:
                        touched[layer, y, word * EDGE + block] = 1


collect_parallel: Collect = compiled(parallel=True)(_collect)
collect_serial: Collect = compiled(serial_copy(_collect))


@compiled(inline="always")
def entry_of(codes: Words, code: int) -> int:
    """Return the entry of the table that holds a code, or the empty one where it belongs."""
    mask = len(codes) - 1
    entry = int((code * _FIBONACCI) >> 20) & mask
    while codes[entry] not in (EMPTY, code):
        entry = (entry + 1) & mask
    return entry


@compiled
def find_slots(codes: Words, slots: Words, wanted: Words, found: Words, used: int) -> int:
    """Find the slots of blocks, add the blocks that are new, and return the number of slots used now.

    Parameters
    ----------
    codes, slots : (2^k,) int64 array
        Modified: the table; it has more entries than there will be blocks.
    wanted : (n,) int64 array
        Codes of blocks, without repetitions.
    found : (n,) int64 array
        Out: their slots.
    used : int
        Number of slots used so far.
    """
    for i in range(len(wanted)):
        entry = entry_of(codes, wanted[i])
        if codes[entry] == EMPTY:
            codes[entry], slots[entry] = wanted[i], used
            used += 1
        found[i] = slots[entry]
    return used


@compiled
def look_up(codes: Words, slots: Words, wanted: Words, found: Words) -> None:
    """Find the slots of blocks; −1 for those that do not exist. Parameters as in `find_slots`."""
    for i in range(len(wanted)):
        entry = entry_of(codes, wanted[i])
        found[i] = slots[entry] if codes[entry] != EMPTY else -1


def _update(
    free: NDArray[np.uint8],
    occupied: NDArray[np.uint8],
    box: Words,
    blocks: Words,
    slots: Words,
    log_odds: NDArray[np.float32],
    model: tuple[np.float32, np.float32, np.float32, np.float32],
) -> None:
    """Add the log-odds of a hit or a miss to the marked voxels of blocks, and clear their bits.

    Parameters
    ----------
    free, occupied : (8 · words,) uint8 array
        Modified: bytes of the bits of the box, in little-endian order; no voxel is in both.
    box : (6,) int64 array
        Keys of the least voxel of the box, and its size W, H, D [voxels].
    blocks : (n,) int64 array
        Indices of the blocks in the box: (bz · H / 8 + by) · W / 8 + bx.
    slots : (n,) int64 array
        Their slots.
    log_odds : (slots, 512) float32 array
        Modified: log-odds of the voxels, NaN where unknown.
    model : tuple of four float32
        Log-odds of a hit and of a miss, and the least and the greatest log-odds of a voxel.
    """
    hit, miss, least, most = model
    wide, high = box[3] // EDGE, box[4] // EDGE
    for i in prange(len(blocks)):
        x, y, z = blocks[i] % wide, blocks[i] // wide % high, blocks[i] // (wide * high)
        voxels = log_odds[slots[i]]
        for row in range(EDGE * EDGE):
            at = ((z * EDGE + row // EDGE) * box[4] + y * EDGE + row % EDGE) * wide + x
            passed, ended = free[at], occupied[at]
            if passed | ended == 0:
                continue
            free[at] = occupied[at] = 0
            for bit in range(EDGE):
                if (passed | ended) >> bit & 1:
                    old = voxels[row * EDGE + bit]
                    old = np.float32(0.0) if np.isnan(old) else old
                    new = old + (hit if ended >> bit & 1 else miss)
                    voxels[row * EDGE + bit] = min(max(new, least), most)


update_parallel: Update = compiled(parallel=True)(_update)
update_serial: Update = compiled(serial_copy(_update))


def warm() -> None:
    """Call the kernels once, so that they are compiled or loaded from the cache."""
    box, touched, zero = np.array([0, 0, 0, 64, 8, 8]), np.zeros((1, 1, 8), np.uint8), np.zeros(1, np.int64)
    bits, codes, one = np.zeros((1, 64), np.int64), np.full(2, EMPTY), np.float32(1.0)
    for collect, update in ((collect_serial, update_serial), (collect_parallel, update_parallel)):
        collect(bits, bits, box, touched)
        data = bits[0].view(np.uint8)
        update(data, data, box, zero, zero, np.zeros((1, VOXELS), np.float32), (one, one, one, one))
    find_slots(codes, np.zeros(2, np.int64), zero, zero.copy(), 0)
    look_up(codes, np.zeros(2, np.int64), zero, zero.copy())
