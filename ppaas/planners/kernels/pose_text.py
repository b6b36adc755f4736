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

_1, _10, _BLOCK, _SCALE = np.uint64(1), np.uint64(10), np.uint64(BLOCK), np.uint64(SCALE)
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
def write_rows(rows: NDArray[np.float64], pieces: Text, ends: NDArray[np.uint64], text: Text) -> Length:
    """Write each row as piece, number, piece, …, number, piece; return the length.

    It is 0 where a number is too large to be written.

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
    at = np.uint64(0)
    columns = rows.shape[1]
    for row in range(rows.shape[0]):
        begin = np.uint64(0)
        for column in range(columns + 1):
            end, to = ends[column], at
            at += end - begin
            while begin < end:
                for ahead in range(_BLOCK):
                    text[to + ahead] = pieces[begin + ahead]
                begin += _BLOCK
                to += _BLOCK
            begin = end
            if column < columns:
                if not abs(rows[row, column]) < MOST:
                    return 0
                at = _write_number(rows[row, column], text, at)
    return np.int64(at)
