"""How the arrays of a cost field are laid out, for the kernels that share them.

Both arrays have one cell more on each side of the map, so that no kernel asks whether a neighbour exists. A cell
(row, column) of the map is element (row + 1)·stride + column + 1 of the flat arrays, with stride = width + 2.

The value of a cell is its cost-to-go in fixed point plus `AT_GOAL`. A blocked cell has `BLOCKED`, which is below
any value, so that "is the new value less?" alone keeps searches out of it.
"""

import numpy as np

BLOCKED = 0
AT_GOAL = 1
UNREACHED = np.uint32(0xFFFFFFFF)
UNREACHED_WIDE = np.int64(0x7FFFFFFFFFFFFFFF)

BUCKET_SHIFT = 12
"""A bucket holds 2¹² = 4096 values: less than the least weight, 4250, so no move ends in the bucket it began in."""

RING = 128
"""Buckets in the ring, a power of two."""

AHEAD = (RING - 9) << BUCKET_SHIFT
"""How far above the lowest bucket a value may be from which moves are made: the longest, 30 413, leads 8 buckets on."""

CHUNK = 256
"""Cells in one chunk of the pool."""

MOST_CHUNKS = 8 + RING
"""Chunks that working off one chunk can take: each cell has 8 neighbours, and each bucket may begin one."""
