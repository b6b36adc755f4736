"""Kernel: write the numbers of a table as decimal text, between constant pieces of text.

Indices are unsigned: numba then omits the check for negative indices, which halves the time.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled

Text = NDArray[np.uint8]
Place = np.unsignedinteger[Any]
Length = int | np.signedinteger[Any]

SCALE = 10**9
"""Numbers are rounded to 10⁻⁹: a nanometre."""

MAX_MAGNITUDE = 9.0e9
"""Exclusive bound of the magnitude of a number: scaled by 10⁹, a larger one would overflow 64 bits."""

WIDEST = 21
"""Bytes of the longest number: sign, ten digits, point, nine digits."""

BLOCK = 8
"""Bytes copied at once. Up to this many bytes beyond the last one may be read and written."""

_1, _2, _3, _4, _5, _6, _7 = (np.uint64(number) for number in range(1, BLOCK))
_10, _BLOCK, _SCALE = np.uint64(10), np.uint64(BLOCK), np.uint64(SCALE)
_DECIMALS = np.uint64(9)
_ZERO, _MINUS, _POINT = np.uint64(ord("0")), ord("-"), ord(".")


@compiled
def _write_number(value: float, text: Text, at: Place) -> Place:
    """Write a number with one to nine decimals at an index of the text; return the index behind it."""
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


@compiled
def _copy(source: Text, begin: Place, end: Place, text: Text, at: Place) -> Place:
    """Copy bytes ``begin`` to ``end`` to an index of the text, in whole blocks; return the index behind them."""
    behind = at + (end - begin)
    while begin < end:
        # All reads come before the writes, so that LLVM merges them into one load and one store.
        a, b, c, d = source[begin], source[begin + _1], source[begin + _2], source[begin + _3]
        e, f, g, h = source[begin + _4], source[begin + _5], source[begin + _6], source[begin + _7]
        text[at], text[at + _1], text[at + _2], text[at + _3] = a, b, c, d
        text[at + _4], text[at + _5], text[at + _6], text[at + _7] = e, f, g, h
        begin += _BLOCK
        at += _BLOCK
    return behind


@compiled
def _changed(rows: NDArray[np.float64], row: int) -> int:
    """Return the number of columns up to the last one in which a row differs from the row before."""
    changed = int(rows.shape[1])
    while row > 0 and changed > 0 and rows[row, changed - 1] == rows[row - 1, changed - 1]:
        changed -= 1
    return changed


@compiled
def write_rows(rows: NDArray[np.float64], pieces: Text, ends: NDArray[np.uint64], text: Text) -> Length:
    """Write each row as piece, number, piece, …, number, piece; return the length, or 0 if a number is too large.

    Trailing columns that are equal to those of the row before are copied from its text: on straight segments of a path
    the orientation does not change.

    Parameters
    ----------
    rows : (n, m) array
        Numbers, whose magnitude must be below `MAX_MAGNITUDE`.
    pieces : (p + ``BLOCK``,) array
        The m + 1 pieces of a row, concatenated (p bytes).
    ends : (m + 1,) array
        Index behind each piece.
    text : array
        Out: the text, from index 0 on; n · (p + m · ``WIDEST``) + ``BLOCK`` bytes suffice.
    """
    at, columns = np.uint64(0), int(rows.shape[1])
    behind = np.zeros(columns + 1, np.uint64)  # index of the begin of the row before, and behind each of its numbers
    for row in range(rows.shape[0]):
        changed, old_end = _changed(rows, row), at
        piece, old = np.uint64(0), behind[changed]
        behind[0] = at
        for column in range(changed):
            if not abs(rows[row, column]) < MAX_MAGNITUDE:
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
    """Compile and call the kernel once."""
    pieces, text = np.frombuffer(bytes(1 + BLOCK), np.uint8), np.zeros(1 + WIDEST + BLOCK, np.uint8)
    write_rows(np.zeros((1, 1)), pieces, np.ones(2, np.uint64), text)
