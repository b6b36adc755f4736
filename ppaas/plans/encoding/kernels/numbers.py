"""Kernel: the numbers of plans as bytes, without loss, and short for values with few decimals or near a prediction.

Format: three bytes with one bit per number, set if it differs from its prediction; then a tag of four bits for each
such number; then its code of up to eight bytes. The code is the value in thousandths; or in millionths, with an offset
of a few units in the last place; or the offset from the prediction in units in the last place; or the eight bytes of
the float64.
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.plans.encoding.kernels.float_bits import bits_of, float_of
from ppaas.plans.encoding.kernels.quaternions import quaternion_near, quaternion_towards

Bytes = NDArray[np.uint8]
Rows = NDArray[np.int64]
Numbers = NDArray[np.float64]
Words = NDArray[np.uint64]

NUMBERS, END_VALUES = 10, 12
"""Numbers of a plan itself (``body.NAMES``), and x, y, qz, qw of its first, last, and last but one pose."""

COUNT = NUMBERS + END_VALUES
"""Numbers per plan."""

MOST = 3 + COUNT // 2 + 8 * COUNT
"""Largest number of bytes per plan."""

_MICROS, _NEAR_ULPS, _FAR_ULPS, _RAW = 7, 13, 14, 15
"""Tags. A tag below the first is the number of bytes of thousandths. From the first tag on: millionths in three or more
bytes."""

_SIZES = np.array((*range(_MICROS), *range(3, 9), 1, 2, 8), np.int64)
"""Bytes of the code, by tag."""

_MILLI_MOST, _MICRO_MOST = 2.0**46, 2.0**51
"""Largest values in thousandths and in millionths."""

_COST_PER_METRE = 1000.0
"""Cost of a metre of free cells on a map of 5 cm, the most common resolution (``ppaas.planners.weights``) [1/m]."""


@compiled
def _read_ends(words: Words, stops: Rows, values: Numbers, spatial: Words) -> None:
    """Copy the end poses of plans into their numbers, as `write_numbers` describes."""
    first = 0
    for plan in range(len(stops)):
        last = stops[plan] - 1
        for pose in range(3):
            row = first if pose == 0 else last if pose == 1 else max(last - 1, first)
            for column in range(4):
                word = words[row, column if column < 2 else column + 3]
                values[plan, NUMBERS + 4 * pose + column] = float_of(np.int64(word))
            for column in range(3):
                spatial[plan, 3 * pose + column] = words[row, 2 + column]
        spatial[plan, 9] = spatial[plan, :9].any()
        first = stops[plan]


@compiled
def _expected(values: Numbers, number: int) -> float:
    """Return the prediction of a number from those before it."""
    if number == 2:
        return float(values[1]) * _COST_PER_METRE
    if number < NUMBERS:
        return 0.0
    pose, column = divmod(number - NUMBERS, 4)
    if pose == 2:
        if column < 2:
            return float(values[NUMBERS + 4 + column])  # on a grid, x or y often equals that of the goal
        at = NUMBERS + 4
        towards: tuple[float, float] = quaternion_towards(values[at] - values[at + 4], values[at + 1] - values[at + 5])
        return towards[column - 2]
    own = 4 + 3 * pose
    return float(values[own + column]) if column < 2 else quaternion_near(values[own + 2])[column - 2]


@compiled
def _size(code: int) -> int:
    size = 0
    while code:
        code, size = code >> 8, size + 1
    return size


@compiled
def _zigzag(whole: int) -> int:
    return whole << 1 if whole >= 0 else (-whole << 1) - 1


@compiled
def _unzigzag(code: int) -> int:
    return code >> 1 if not code & 1 else -(code + 1 >> 1)


@compiled
def _tag_and_code(value: float, expected: float) -> tuple[int, int]:
    """Return the tag and code of a number that differs from its prediction."""
    word = bits_of(value)
    ulps = word - bits_of(expected)
    if -128 <= ulps < 128:
        return _NEAR_ULPS, ulps + 128
    scaled = value * 1e3
    if -_MILLI_MOST < scaled < _MILLI_MOST:
        whole = int(np.rint(scaled))
        if whole / 1e3 == value and (whole != 0 or word == 0):
            code = _zigzag(whole)
            return _size(code), code
    if -(1 << 15) <= ulps < 1 << 15:
        return _FAR_ULPS, ulps + (1 << 15)
    scaled = value * 1e6
    if -_MICRO_MOST < scaled < _MICRO_MOST:
        whole = int(np.rint(scaled))
        places = word - bits_of(whole / 1e6)
        if -8 <= places < 8:
            code = _zigzag(whole) << 4 | places + 8
            return _MICROS + max(_size(code), 3) - 3, code
    return _RAW, word


@compiled
def _value(tag: int, code: int, expected: float) -> float:
    if tag < _MICROS:
        return _unzigzag(code) / 1e3
    if tag < _NEAR_ULPS:
        return float_of(bits_of(_unzigzag(code >> 4) / 1e6) + (code & 15) - 8)
    if tag == _RAW:
        return float_of(code)
    return float_of(bits_of(expected) + code - (128 if tag == _NEAR_ULPS else 1 << 15))


@compiled
def write_numbers(words: Words, stops: Rows, values: Numbers, spatial: Words, out: Bytes, ends: Rows) -> None:
    """Encode the numbers of plans.

    Parameters
    ----------
    words : (n, 7) uint64 array
        Bits of the poses of all plans, one plan after the other.
    stops : (m,) int64 array
        For each plan the row after its last pose.
    values : (m, ``COUNT``) float64 array
        The first ``NUMBERS`` of each plan. Out: x, y, qz, qw of the first, last, and last but one pose; a plan with
        fewer poses repeats some.
    spatial : (m, 10) uint64 array
        Out: bits of z, qx, qy of these poses, and last whether any is not zero.
    out : (k,) uint8 array
        Out: the bytes; k is at least ``MOST`` m.
    ends : (m,) int64 array
        Out: end of the bytes of each plan.
    """
    _read_ends(words, stops, values, spatial)
    at = 0
    tags, codes = np.empty(COUNT, np.int64), np.empty(COUNT, np.int64)
    for plan in range(len(values)):
        encoded, mask = 0, 0
        # Differences from the predictions.
        for number in range(COUNT):
            value, expected = values[plan, number], _expected(values[plan], number)
            if bits_of(value) != bits_of(expected):
                mask |= 1 << number
                tags[encoded], codes[encoded] = _tag_and_code(value, expected)
                encoded += 1
        # Mask, tags, codes.
        at = _write(out, at, mask, 3)
        for number in range(0, encoded, 2):
            after = tags[number + 1] if number + 1 < encoded else 0
            at = _write(out, at, tags[number] | after << 4, 1)
        for number in range(encoded):
            at = _write(out, at, codes[number], _SIZES[tags[number]])
        ends[plan] = at


@compiled
def read_numbers(data: Bytes, begin: int, end: int, values: Numbers) -> int:
    """Decode the numbers of a plan.

    Parameters
    ----------
    data : (k,) uint8 array
        Bytes of plans.
    begin, end : int
        Begin of the numbers, and limit of their end.
    values : (``COUNT``,) float64 array
        Out: the numbers.

    Returns
    -------
    int
        End of the numbers; beyond ``end`` if they are damaged.
    """
    mask = _read(data, begin, end, 3)
    encoded = 0
    for number in range(COUNT):
        encoded += mask >> number & 1
    head = begin + 3
    at = head + (encoded + 1) // 2
    encoded = 0
    for number in range(COUNT):
        expected = _expected(values, number)
        if mask >> number & 1:
            tag = _read(data, head + encoded // 2, end, 1) >> 4 * (encoded & 1) & 15
            values[number] = _value(tag, _read(data, at, end, _SIZES[tag]), expected)
            encoded, at = encoded + 1, at + _SIZES[tag]
        else:
            values[number] = expected
    return int(at)


@compiled
def _write(out: Bytes, at: int, code: int, size: int) -> int:
    for byte in range(size):
        out[at + byte] = np.uint8(code >> (8 * byte) & 255)
    return at + size


@compiled
def _read(data: Bytes, at: int, end: int, size: int) -> int:
    """Return a number of ``size`` bytes; zero if they reach beyond the end."""
    code = np.int64(0)
    if at + size <= end:
        for byte in range(size):
            code |= np.int64(data[at + byte]) << (8 * byte)
    return int(code)


def warm() -> None:
    """Call the kernel once."""
    values, rows = np.zeros((1, COUNT)), np.zeros(1, np.int64)
    words = np.zeros((1, 7), np.uint64)
    words.flags.writeable = False
    write_numbers(words, rows + 1, values, np.empty((1, 10), np.uint64), np.empty(MOST, np.uint8), rows)
