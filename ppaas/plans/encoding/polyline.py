"""Polylines as text, by the Encoded Polyline Algorithm Format: some four characters a point.

Source: Google Maps Platform, *Encoded Polyline Algorithm Format*. Decoders take the number of decimals as precision.
"""

import numpy as np
from numpy.typing import NDArray

DECIMALS = 3
"""Decimals of a coordinate in metres: points are rounded to millimetres."""

_BITS, _MORE, _OFFSET = 5, 0x20, 63


def polyline_of(points: NDArray[np.float64], decimals: int = DECIMALS) -> str:
    """Return (n, 2) points as text: x and y of the first, then the differences to the point before."""
    rounded = np.rint(points * 10.0**decimals).astype(np.int64)
    steps = np.diff(rounded, axis=0, prepend=np.zeros((1, 2), np.int64)).reshape(-1)
    values = (steps << 1) ^ (steps >> 63)  # the sign is the last bit
    widest = max(int(values.max(initial=1)).bit_length(), 1)
    parts = values[:, None] >> np.arange(0, widest, _BITS)
    is_used = parts != 0
    is_used[:, 0] = True
    characters = (parts & (_MORE - 1)) + _OFFSET
    characters[:, :-1] += _MORE * is_used[:, 1:]
    return str(characters[is_used].astype(np.uint8).tobytes(), "ascii")
