"""Headings that can be written shortly: those of the eight moves on a grid, and those that follow from other numbers.

What is computed here is computed the same on every machine: of additions, multiplications, divisions and square roots
alone, which IEEE 754 defines to the last bit. Sines of the C library are not.
"""

import math

import numpy as np

MOVES = np.array([(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)], np.int64)
"""x, y of the eight moves, by eighths of a turn."""

SINE, COSINE = 0.3826834323650898, 0.9238795325112867
_HALF = 0.7071067811865475

QUATERNIONS = np.array(
    [
        (0.0, 1.0), (SINE, COSINE), (_HALF, 0.7071067811865476), (COSINE, 0.38268343236508984),
        (1.0, 6.123233995736766e-17), (-COSINE, 0.38268343236508984), (-_HALF, 0.7071067811865476), (-SINE, COSINE),
    ]
)  # fmt: skip
"""qz, qw of their headings, as ``ppaas.geometry.poses_along`` makes them."""

_SINE = tuple((-1.0) ** n / float(math.factorial(2 * n + 1)) for n in range(12, -1, -1))
_COSINE = tuple((-1.0) ** n / float(math.factorial(2 * n)) for n in range(12, -1, -1))
"""Of the series of both, which are exact enough for half of any yaw from −π to π."""


def quaternion_near(yaw: float) -> tuple[float, float]:
    """Return qz, qw of a yaw from −π to π [rad], a few units in the last place from the true ones."""
    half = min(max(yaw, -4.0), 4.0) * 0.5
    square = half * half
    sine = cosine = 0.0
    for of_sine, of_cosine in zip(_SINE, _COSINE, strict=True):
        sine = sine * square + of_sine
        cosine = cosine * square + of_cosine
    return half * sine, cosine


def quaternion_towards(x: float, y: float) -> tuple[float, float]:
    """Return qz, qw of the heading along (x, y), a few units in the last place from the true ones."""
    length = math.sqrt(x * x + y * y)
    if not 0.0 < length < math.inf:
        return 0.0, 1.0
    cosine, sine = x / length, abs(y) / length
    larger = math.sqrt((1.0 + abs(cosine)) * 0.5)
    smaller = sine / (2.0 * larger)
    qz, qw = (smaller, larger) if cosine >= 0.0 else (larger, smaller)
    if y == 0.0 and x < 0.0:
        qw = float(QUATERNIONS[4, 1])
    return (-qz if y < 0.0 else qz), qw
