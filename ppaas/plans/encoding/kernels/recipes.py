"""Kernel: lists of integers as bytes: zigzag-encoded differences in seven bits a byte (LEB128)."""

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled

Bytes = NDArray[np.uint8]
Rows = NDArray[np.int64]

MOST = 10
"""Largest number of bytes per number."""


@compiled
def write_recipes(numbers: Rows, stops: Rows, out: Bytes, ends: Rows) -> None:
    """Encode lists that follow each other up to ``stops``; write the end of the bytes of each to ``ends``."""
    at = begin = 0
    for recipe in range(len(stops)):
        previous = np.int64(0)
        for place in range(begin, stops[recipe]):
            step = numbers[place] - previous
            previous = numbers[place]
            remaining = step << 1 if step >= 0 else (-step << 1) - 1
            while remaining >= 128:
                out[at] = np.uint8(remaining & 127 | 128)
                remaining, at = remaining >> 7, at + 1
            out[at] = np.uint8(remaining)
            at += 1
        begin = stops[recipe]
        ends[recipe] = at


@compiled
def read_recipes(data: Bytes, ends: Rows, numbers: Rows, stops: Rows) -> bool:
    """Decode lists whose bytes follow each other up to ``ends``; return whether none ends inside a number."""
    at = decoded = 0
    for recipe in range(len(ends)):
        number, remaining, shift = np.int64(0), np.int64(0), 0
        while at < ends[recipe]:
            remaining |= np.int64(data[at] & 127) << shift
            shift += 7
            if data[at] < 128:
                number += remaining >> 1 if not remaining & 1 else -(remaining + 1 >> 1)
                numbers[decoded] = number
                remaining, shift, decoded = np.int64(0), 0, decoded + 1
            at += 1
        stops[recipe] = decoded
        if shift:
            return False
    return True


def warm() -> None:
    """Call the kernels once."""
    rows, out = np.ones(1, np.int64), np.zeros(MOST, np.uint8)
    write_recipes(rows, rows, out, rows.copy())
    out.flags.writeable = False
    read_recipes(out, rows, np.empty(MOST, np.int64), rows.copy())
