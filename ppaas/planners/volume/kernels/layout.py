"""How the arrays of a field in space are laid out, and the 26 moves, for the kernels that share them.

All arrays have one voxel more on each side of the map, so that no kernel asks whether a neighbour exists. A voxel
(layer, row, column) of the map is element (layer + 1)·plane + (row + 1)·stride + column + 1 of the flat arrays, with
stride = width + 2 and plane = (height + 2)·stride.

The value of a voxel is its cost-to-go in fixed point plus `AT_GOAL`; a blocked one has `BLOCKED`, below any value.
"""

import itertools

import numpy as np

BLOCKED = 0
AT_GOAL = 1
UNREACHED = np.uint32(0xFFFFFFFF)

MOST_VALUE = 0xFFFF0000
"""No value may come near `UNREACHED`: a million free voxels, which no way through a map of that size has."""

BUCKET_SHIFT = 12
"""A bucket holds 2¹² = 4096 values: less than the least weight, 4250, so no move ends in the bucket it began in."""

RING = 32
"""Buckets in the ring, a power of two. The longest move weighs 37 248; with the distance to the target, which it may
take the search away from, as much again: at most 19 buckets ahead."""

CHUNK = 256
"""Voxels in one chunk of the pool."""

MOST_CHUNKS = 26 + RING
"""Chunks that working off one chunk can take: each voxel has 26 neighbours, and each bucket may begin one."""


def _all_moves() -> list[tuple[int, ...]]:
    moves = [move for move in itertools.product((-1, 0, 1), repeat=3) if any(move)]
    return sorted(moves, key=lambda move: sum(map(abs, move)))


def _needed(move: tuple[int, ...]) -> int:
    """Return the bits of the moves with one axis less; those need in turn what they need."""
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
"""Axes of each move, less one: which weight it has."""

NEEDS = tuple(_needed(move) for move in MOVES)
"""For each move which of the earlier ones must be open, one bit each: no corner is cut."""
