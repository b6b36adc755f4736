"""Layout of the arrays of a cost field, for the kernels that share them.

The costs and the field have a margin of one blocked cell on each side of the map, so that kernels need no bounds checks
for neighbours. The cell (row, column) of the map is element (row + 1)·stride + column + 1 of the flat arrays, with
stride = width + 2.

The value of a cell is its cost-to-go in fixed point plus `AT_GOAL`. Blocked cells have the value `BLOCKED`, below any
other, so that the comparison "new value < old value" alone keeps searches out of them.
"""

import numpy as np

BLOCKED = 0
AT_GOAL = 1
UNREACHED = np.uint32(0xFFFFFFFF)
UNREACHED_WIDE = np.int64(0x7FFFFFFFFFFFFFFF)

BUCKET_SHIFT = 12
"""A bucket holds 2¹² = 4096 values: less than the least weight, 4250, so no move ends in the bucket where it began."""

RING = 128
"""Number of buckets in the ring, a power of two."""

AHEAD = (RING - 9) << BUCKET_SHIFT
"""Maximum distance from the lowest bucket of a value from which moves are made: the most expensive move, 30 413, leads
8 buckets ahead."""

CHUNK = 256
"""Cells in one chunk of the pool."""

MAX_CHUNKS = 8 + RING
"""Maximum number of chunks that expanding one chunk can fill: 8 neighbours per cell, and one partly filled chunk per
bucket."""
