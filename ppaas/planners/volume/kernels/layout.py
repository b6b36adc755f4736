"""Layout of the arrays of a cost field in space, and the 26 moves.

All arrays have a margin of one voxel on each side of the map, so that kernels need no bounds checks for neighbours. The
voxel (layer, row, column) of the map is element (layer + 1)·plane + (row + 1)·stride + column + 1 of the flat arrays,
with stride = width + 2 and plane = (height + 2)·stride.

The value of a voxel is its cost-to-go in fixed point plus `AT_GOAL`. Blocked voxels have the value `BLOCKED`, below any
other.
"""

import itertools

import numpy as np

BLOCKED = 0
AT_GOAL = 1
UNREACHED = np.uint32(0xFFFFFFFF)

MAX_VALUE = 0xFFFF0000
"""Largest value: about a million free voxels. Greater ones could collide with `UNREACHED`."""

BUCKET_SHIFT = 12
"""A bucket holds 2¹² = 4096 values: less than the least weight, 4250, so no move ends in the bucket where it began."""

RING = 32
"""Number of buckets in the ring, a power of two. The most expensive move weighs 37 248, and may increase the estimate
by as much: keys are at most 19 buckets ahead."""

CHUNK = 256
"""Voxels in one chunk of the pool."""

MAX_CHUNKS = 26 + RING
"""Maximum number of chunks that expanding one chunk can fill: 26 neighbours per voxel, and one partly filled chunk per
bucket."""


def _all_moves() -> list[tuple[int, ...]]:
    moves = [move for move in itertools.product((-1, 0, 1), repeat=3) if any(move)]
    return sorted(moves, key=lambda move: sum(map(abs, move)))


def _needed(move: tuple[int, ...]) -> int:
    """Return the bits of the moves along one axis less; those have requirements of their own."""
    bits = 0
    for axis in range(3):
        shorter = tuple(0 if other == axis else step for other, step in enumerate(move))
        if move[axis] and any(shorter):
            bits |= 1 << MOVES.index(shorter)
    return bits


MOVES = _all_moves()
"""Layers, rows and columns of each move: 6 along one axis, 12 along two, 8 along three."""

UP = tuple(move[0] for move in MOVES)
DOWN = tuple(move[1] for move in MOVES)
RIGHT = tuple(move[2] for move in MOVES)

KINDS = tuple(sum(map(abs, move)) - 1 for move in MOVES)
"""Number of axes of each move, minus one: the row of its weight."""

NEEDS = tuple(_needed(move) for move in MOVES)
"""For each move, the bits of the earlier moves that must be free, so that it cuts no corner."""
