"""The eight moves on a grid and their headings."""

import numpy as np

MOVES = np.array([(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)], np.int64)
"""x, y of the eight moves, by eighths of a turn from the x axis."""

SINE, COSINE = 0.3826834323650898, 0.9238795325112867
_HALF = 0.7071067811865475

QUATERNIONS = np.array(
    [
        (0.0, 1.0), (SINE, COSINE), (_HALF, 0.7071067811865476), (COSINE, 0.38268343236508984),
        (1.0, 6.123233995736766e-17), (-COSINE, 0.38268343236508984), (-_HALF, 0.7071067811865476), (-SINE, COSINE),
    ]
)  # fmt: skip
"""qz, qw of their headings, bit for bit as ``ppaas.geometry.poses_along`` computes them."""
