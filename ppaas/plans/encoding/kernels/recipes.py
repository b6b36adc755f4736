"""Kernel: lists of numbers as bytes, each by how it differs from the one before, seven bits a byte."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]
Rows = NDArray[np.int64]

MOST = 10
"""Bytes of a number at most."""


@njit(cache=True, nogil=True, error_model="numpy")
def write_recipes(numbers: Rows, stops: Rows, out: Bytes, ends: Rows) -> None:
    """Write lists that lie one behind the other up to ``stops``; ``ends`` gets where the bytes of each end."""
    at = begin = 0
    for recipe in range(len(stops)):
        before = np.int64(0)
        for place in range(begin, stops[recipe]):
            step = numbers[place] - before
            before = numbers[place]
            left = step << 1 if step >= 0 else (-step << 1) - 1
            while left >= 128:
                out[at] = np.uint8(left & 127 | 128)
                left, at = left >> 7, at + 1
            out[at] = np.uint8(left)
            at += 1
        begin = stops[recipe]
        ends[recipe] = at


@njit(cache=True, nogil=True, error_model="numpy")
def read_recipes(data: Bytes, ends: Rows, numbers: Rows, stops: Rows) -> bool:
    """Read lists whose bytes lie one behind the other up to ``ends``; tell whether none ends within a number."""
    at = told = 0
    for recipe in range(len(ends)):
        number, left, shift = np.int64(0), np.int64(0), 0
        while at < ends[recipe]:
            left |= np.int64(data[at] & 127) << shift
            shift += 7
            if data[at] < 128:
                number += left >> 1 if not left & 1 else -(left + 1 >> 1)
                numbers[told] = number
                left, shift, told = np.int64(0), 0, told + 1
            at += 1
        stops[recipe] = told
        if shift:
            return False
    return True


def warm() -> None:
    """Call the kernels once."""
    rows, out = np.ones(1, np.int64), np.zeros(MOST, np.uint8)
    write_recipes(rows, rows, out, rows.copy())
    out.flags.writeable = False
    read_recipes(out, rows, np.empty(MOST, np.int64), rows.copy())
