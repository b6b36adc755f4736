"""Kernel: the numbers of plans as bytes, bit for bit and short where they are what people and rasters give.

First three bytes of a bit for each number that is not what is expected of it; then a tag of four bits for each of
these, and up to eight bytes: so many thousandths; so many millionths and a few units in the last place; how many units
in the last place it lies beside what is expected; or its own eight bytes.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ppaas.plans.encoding.kernels.float_bits import bits_of, float_of
from ppaas.plans.encoding.kernels.quaternions import quaternion_near, quaternion_towards

Bytes = NDArray[np.uint8]
Rows = NDArray[np.int64]
Numbers = NDArray[np.float64]
Words = NDArray[np.uint64]

NUMBERS, PLACES = 10, 12
"""Of a plan itself (``body.NUMBERS``), and x, y, qz, qw of its first pose, its last and the last but one."""

COUNT = NUMBERS + PLACES
MOST = 3 + COUNT // 2 + 8 * COUNT
"""Bytes of a plan at most."""

_MICRO, _BESIDE, _FAR_BESIDE, _RAW = 7, 13, 14, 15
"""Tags; those before the first say how many bytes of thousandths follow, those from it on three bytes of millionths and
more."""

_SIZES = np.array((*range(_MICRO), *range(3, 9), 1, 2, 8), np.int64)
_MILLI_MOST, _MICRO_MOST = 2.0**46, 2.0**51

_COST_PER_METRE = 1000.0
"""What a metre of free cells costs on a map of 5 cm, the most common (``ppaas.planners.weights``)."""


@njit(cache=True, nogil=True, error_model="numpy")
def _take_ends(words: Words, stops: Rows, values: Numbers, beyond: Words) -> None:
    """Write what the numbers of plans tell of the poses at their ends, as `write_numbers`."""
    first = 0
    for plan in range(len(stops)):
        last = stops[plan] - 1
        for place in range(3):
            row = first if place == 0 else last if place == 1 else max(last - 1, first)
            for column in range(4):
                word = words[row, column if column < 2 else column + 3]
                values[plan, NUMBERS + 4 * place + column] = float_of(np.int64(word))
            for column in range(3):
                beyond[plan, 3 * place + column] = words[row, 2 + column]
        beyond[plan, 9] = beyond[plan, :9].any()
        first = stops[plan]


@njit(cache=True, nogil=True, error_model="numpy")
def _expected(values: Numbers, number: int) -> float:
    """Return what is expected of a number by those before it."""
    if number == 2:
        return float(values[1]) * _COST_PER_METRE
    if number < NUMBERS:
        return 0.0
    place, column = divmod(number - NUMBERS, 4)
    if place == 2:
        if column < 2:
            return float(values[NUMBERS + 4 + column])  # on a grid one of both is often the same
        at = NUMBERS + 4
        towards: tuple[float, float] = quaternion_towards(values[at] - values[at + 4], values[at + 1] - values[at + 5])
        return towards[column - 2]
    own = 4 + 3 * place
    return float(values[own + column]) if column < 2 else quaternion_near(values[own + 2])[column - 2]


@njit(cache=True, nogil=True, error_model="numpy")
def _size(code: int) -> int:
    size = 0
    while code:
        code, size = code >> 8, size + 1
    return size


@njit(cache=True, nogil=True, error_model="numpy")
def _folded(whole: int) -> int:
    return whole << 1 if whole >= 0 else (-whole << 1) - 1


@njit(cache=True, nogil=True, error_model="numpy")
def _unfolded(code: int) -> int:
    return code >> 1 if not code & 1 else -(code + 1 >> 1)


@njit(cache=True, nogil=True, error_model="numpy")
def _told(value: float, expected: float) -> tuple[int, int]:
    """Return the tag and code of a number that is not what is expected."""
    word = bits_of(value)
    beside = word - bits_of(expected)
    if -128 <= beside < 128:
        return _BESIDE, beside + 128
    scaled = value * 1e3
    if -_MILLI_MOST < scaled < _MILLI_MOST:
        whole = int(np.rint(scaled))
        if whole / 1e3 == value and (whole != 0 or word == 0):
            code = _folded(whole)
            return _size(code), code
    if -(1 << 15) <= beside < 1 << 15:
        return _FAR_BESIDE, beside + (1 << 15)
    scaled = value * 1e6
    if -_MICRO_MOST < scaled < _MICRO_MOST:
        whole = int(np.rint(scaled))
        places = word - bits_of(whole / 1e6)
        if -8 <= places < 8:
            code = _folded(whole) << 4 | places + 8
            return _MICRO + max(_size(code), 3) - 3, code
    return _RAW, word


@njit(cache=True, nogil=True, error_model="numpy")
def _value(tag: int, code: int, expected: float) -> float:
    if tag < _MICRO:
        return _unfolded(code) / 1e3
    if tag < _BESIDE:
        return float_of(bits_of(_unfolded(code >> 4) / 1e6) + (code & 15) - 8)
    if tag == _RAW:
        return float_of(code)
    return float_of(bits_of(expected) + code - (128 if tag == _BESIDE else 1 << 15))


@njit(cache=True, nogil=True, error_model="numpy")
def write_numbers(words: Words, stops: Rows, values: Numbers, beyond: Words, out: Bytes, ends: Rows) -> None:
    """Write the numbers of plans.

    Parameters
    ----------
    words : (n, 7) array
        The bits of the poses of all plans, one plan after the other.
    stops : (m,) array
        For each plan the row behind its last pose.
    values : (m, ``COUNT``) array
        The first ``NUMBERS`` of each plan. Gets x, y, qz, qw of the first pose, the last and the last but one; where
        there are fewer, some are the same.
    beyond : (m, 10) array
        Gets the bits of z, qx, qy of these, and last whether any is not zero.
    out : (k,) array
        ``MOST`` bytes for each plan.
    ends : (m,) array
        Gets where each plan ends.
    """
    _take_ends(words, stops, values, beyond)
    at = 0
    tags, codes = np.empty(COUNT, np.int64), np.empty(COUNT, np.int64)
    for plan in range(len(values)):
        told, mask = 0, 0
        for number in range(COUNT):
            value, expected = values[plan, number], _expected(values[plan], number)
            if bits_of(value) != bits_of(expected):
                mask |= 1 << number
                tags[told], codes[told] = _told(value, expected)
                told += 1
        at = _write(out, at, mask, 3)
        for number in range(0, told, 2):
            after = tags[number + 1] if number + 1 < told else 0
            at = _write(out, at, tags[number] | after << 4, 1)
        for number in range(told):
            at = _write(out, at, codes[number], _SIZES[tags[number]])
        ends[plan] = at


@njit(cache=True, nogil=True, error_model="numpy")
def read_numbers(data: Bytes, begin: int, end: int, values: Numbers) -> int:
    """Read the numbers of a plan.

    Parameters
    ----------
    data : (k,) array
    begin, end : int
        Where they begin, and up to where they may go.
    values : (``COUNT``,) array
        Gets them.

    Returns
    -------
    int
        Where they end; beyond what they may if they are damaged.
    """
    mask = _read(data, begin, end, 3)
    told = 0
    for number in range(COUNT):
        told += mask >> number & 1
    head = begin + 3
    at = head + (told + 1) // 2
    told = 0
    for number in range(COUNT):
        expected = _expected(values, number)
        if mask >> number & 1:
            tag = _read(data, head + told // 2, end, 1) >> 4 * (told & 1) & 15
            values[number] = _value(tag, _read(data, at, end, _SIZES[tag]), expected)
            told, at = told + 1, at + _SIZES[tag]
        else:
            values[number] = expected
    return int(at)


@njit(cache=True, nogil=True, error_model="numpy")
def _write(out: Bytes, at: int, code: int, size: int) -> int:
    for place in range(size):
        out[at + place] = np.uint8(code >> (8 * place) & 255)
    return at + size


@njit(cache=True, nogil=True, error_model="numpy")
def _read(data: Bytes, at: int, end: int, size: int) -> int:
    """Return a number of so many bytes; zero if they are not all there."""
    code = np.int64(0)
    if at + size <= end:
        for place in range(size):
            code |= np.int64(data[at + place]) << (8 * place)
    return int(code)


def warm() -> None:
    """Call the kernel once."""
    values, rows = np.zeros((1, COUNT)), np.zeros(1, np.int64)
    words = np.zeros((1, 7), np.uint64)
    words.flags.writeable = False
    write_numbers(words, rows + 1, values, np.empty((1, 10), np.uint64), np.empty(MOST, np.uint8), rows)
