"""Kernel: numbers of a table written as decimal text between pieces that stay the same.

Places are unsigned: an index that cannot count from the end needs no look whether it does, which halves the time.
"""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Text = NDArray[np.uint8]
Place = np.unsignedinteger[Any]
Length = int | np.signedinteger[Any]

SCALE = 10**9
"""Numbers are written to the billionth: of a metre, that is the size of a molecule."""

MOST = 9.0e9
"""No number may be as large: its billionths would not fit 64 bits."""

WIDEST = 21
"""Bytes of the longest number: sign, ten digits, point, nine digits."""

BLOCK = 8
"""Bytes that are copied at a time; so many may be read and written behind the last."""

_1, _2, _3, _4, _5, _6, _7 = (np.uint64(number) for number in range(1, BLOCK))
_10, _BLOCK, _SCALE = np.uint64(10), np.uint64(BLOCK), np.uint64(SCALE)
_DECIMALS = np.uint64(9)
_ZERO, _MINUS, _POINT = np.uint64(ord("0")), ord("-"), ord(".")


@njit(cache=True, nogil=True, error_model="numpy")
def _write_number(value: float, text: Text, at: Place) -> Place:
    """Write a number with one to nine decimals at a place of the text; return the place behind it."""
    scaled = np.uint64(np.rint(abs(value) * SCALE))
    if value < 0.0 and scaled > 0:
        text[at] = _MINUS
        at += _1
    whole = scaled // _SCALE
    point = at + _1
    left = whole // _10
    while left > 0:
        left //= _10
        point += _1
    place = point
    while place > at:
        place -= _1
        text[place] = _ZERO + whole % _10
        whole //= _10
    text[point] = _POINT
    rest, last = np.uint32(scaled % _SCALE), point + _DECIMALS
    if rest == 0:
        last = point + _1
    else:
        while rest % np.uint32(10) == 0:
            rest //= np.uint32(10)
            last -= _1
    place = last
    while place > point:
        text[place] = _ZERO + rest % np.uint32(10)
        rest //= np.uint32(10)
        place -= _1
    return last + _1


@njit(cache=True, nogil=True, error_model="numpy")
def _copy(source: Text, begin: Place, end: Place, text: Text, at: Place) -> Place:
    """Copy a part to a place of the text, up to ``BLOCK`` - 1 bytes more than it has; return the place behind it."""
    behind = at + (end - begin)
    while begin < end:
        # All are read before any is written: then it is one load and one store.
        a, b, c, d = source[begin], source[begin + _1], source[begin + _2], source[begin + _3]
        e, f, g, h = source[begin + _4], source[begin + _5], source[begin + _6], source[begin + _7]
        text[at], text[at + _1], text[at + _2], text[at + _3] = a, b, c, d
        text[at + _4], text[at + _5], text[at + _6], text[at + _7] = e, f, g, h
        begin += _BLOCK
        at += _BLOCK
    return behind


@njit(cache=True, nogil=True, error_model="numpy")
def _changed(rows: NDArray[np.float64], row: int) -> int:
    """Return how many columns there are up to the last in which a row is another than the one before."""
    changed = int(rows.shape[1])
    while row > 0 and changed > 0 and rows[row, changed - 1] == rows[row - 1, changed - 1]:
        changed -= 1
    return changed


@njit(cache=True, nogil=True, error_model="numpy")
def write_rows(rows: NDArray[np.float64], pieces: Text, ends: NDArray[np.uint64], text: Text) -> Length:
    """Write each row as piece, number, piece, …, number, piece; return the length.

    It is 0 where a number is too large to be written. What is at the end of a row as in the row before is copied from
    there: paths run straight ahead for long.

    Parameters
    ----------
    rows : (n, m) array
        Below ``MOST``.
    pieces : (p + ``BLOCK``,) array
        The m + 1 pieces of a row, one behind the other.
    ends : (m + 1,) array
        Where each of them ends.
    text : array
        Filled from its beginning: n · (p + m · ``WIDEST``) + ``BLOCK`` bytes are enough.
    """
    at, columns = np.uint64(0), int(rows.shape[1])
    behind = np.zeros(columns + 1, np.uint64)  # where the row before begins, and where each of its numbers ends
    for row in range(rows.shape[0]):
        changed, old_end = _changed(rows, row), at
        piece, old = np.uint64(0), behind[changed]
        behind[0] = at
        for column in range(changed):
            if not abs(rows[row, column]) < MOST:
                return 0
            at = _write_number(rows[row, column], text, _copy(pieces, piece, ends[column], text, at))
            piece, behind[column + 1] = ends[column], at
        if changed == columns:
            at = _copy(pieces, piece, ends[columns], text, at)
            continue
        for column in range(changed, columns):
            behind[column + 1] += at - old
        at = _copy(text, old, old_end, text, at)
    return np.int64(at)


def warm() -> None:
    """Compile, or load what was compiled."""
    pieces, text = np.frombuffer(bytes(1 + BLOCK), np.uint8), np.zeros(1 + WIDEST + BLOCK, np.uint8)
    write_rows(np.zeros((1, 1)), pieces, np.ones(2, np.uint64), text)
