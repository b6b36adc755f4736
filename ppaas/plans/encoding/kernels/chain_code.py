"""Kernel: encode segments of waypoints as chain codes, and decode stored segments."""

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.plans.encoding.kernels.float_bits import bits_of, float_of
from ppaas.plans.encoding.kernels.grid_moves import MOVES, QUATERNIONS

Bytes = NDArray[np.uint8]
Words = NDArray[np.uint64]
Rows = NDArray[np.int64]

CHAIN, FLAT, SPATIAL = 1, 2, 3
"""Encoding of a segment: chain code; x, y and heading of each pose; or complete poses."""

HEAD = 24
"""Bytes of a chain code before its directions: number of waypoints, step, x and y of the first."""

EXACT = 2 | 2 << 2
"""Offset bits of a waypoint that lies exactly at its grid position."""

PER_METRE = 1e9
"""Units of a coordinate per metre."""

_FARTHEST = 1e6
"""Largest coordinate [m]; up to it, a nanometre is more than a unit in the last place of a float64."""

_SINES, _COSINES = np.ascontiguousarray(QUATERNIONS.view(np.uint64).T)

_SINE_HASH, _SIXTEENTH = np.uint64(0xC0C6848050B0787), np.uint64(60)
"""Multiplicative perfect hash of the eight sines: the highest four bits of the products differ."""

_DIRECTIONS = np.zeros(16, np.int64)
_DIRECTIONS[(_SINES * _SINE_HASH) >> _SIXTEENTH] = np.arange(8)
_LONGEST = 1 << 32

_WIDTHS = np.array((7, 3, 8), np.int64)
"""Bits per waypoint, by packing."""


@compiled
def _nanometres(word: np.uint64) -> int:
    """Return a coordinate in nanometres, given the bits of its value in metres."""
    return int(np.rint(min(max(float_of(np.int64(word)), -_FARTHEST), _FARTHEST) * PER_METRE))


@compiled
def _ulp_offset(word: np.uint64, unit: int) -> int:
    """Return the offset of a coordinate from its nanometres in units in the last place, plus 2."""
    return int(np.int64(word)) - bits_of(unit / PER_METRE) + 2


@compiled
def _encoded(words: Words, row: int, x: int, y: int) -> int:
    """Return the byte of a waypoint: its direction and both offsets; -1 if it cannot be encoded."""
    sine = words[row, 5]
    direction = _DIRECTIONS[(sine * _SINE_HASH) >> _SIXTEENTH]
    if (
        sine != _SINES[direction]
        or words[row, 6] != _COSINES[direction]
        or words[row, 2] | words[row, 3] | words[row, 4] != 0
    ):
        return -1
    offset_x, offset_y = _ulp_offset(words[row, 0], x), _ulp_offset(words[row, 1], y)
    if not 0 <= offset_x < 4 or not 0 <= offset_y < 4:
        return -1
    return int(direction | offset_x << 3 | offset_y << 5)


@compiled
def write_chains(words: Words, begins: Rows, ends: Rows, out: Bytes, stops: Rows) -> None:
    """Write the chain codes of segments of (n, 7) poses.

    Parameters
    ----------
    words : (n, 7) uint64 array
        Bits of the poses.
    begins, ends : (m,) int64 array
        Rows of each segment, the end excluded.
    out : (k,) uint8 array
        Out: the codes, a byte per waypoint after one and `HEAD` bytes per segment.
    stops : (m,) int64 array
        Out: end of the code of each segment. A segment that does not move from cell to cell has an empty code.
    """
    at = 0
    for segment in range(len(begins)):
        begin, end = begins[segment], ends[segment]
        head = at
        at += HEAD + 1
        x, y = _nanometres(words[begin, 0]), _nanometres(words[begin, 1])
        out[head] = CHAIN
        _write(out, head + 1, end - begin, 4)
        _write(out, head + 9, x, 8)
        _write(out, head + 17, y, 8)
        step = 0
        if end - begin > 1:
            step = max(abs(_nanometres(words[begin + 1, 0]) - x), abs(_nanometres(words[begin + 1, 1]) - y))
        _write(out, head + 5, step, 4)
        fits = step < _LONGEST
        for row in range(begin, end):
            code = _encoded(words, row, x, y)
            if code < 0 or not fits:
                fits = False
                break
            out[at] = code
            at += 1
            if row + 1 < end:
                direction = code & 7
                before_x, before_y = x, y
                x, y = _nanometres(words[row + 1, 0]), _nanometres(words[row + 1, 1])
                fits = x - before_x == MOVES[direction, 0] * step and y - before_y == MOVES[direction, 1] * step
        if not fits:
            at = head
        stops[segment] = at


@compiled
def read_segments(data: Bytes, kinds: Rows, begins: Rows, rows: Rows, words: Words) -> None:
    """Decode the waypoints of segments.

    Parameters
    ----------
    data : (k,) uint8 array
        Packed segments. A chain without its first byte; else the differences between consecutive waypoints, bytes of
        equal significance side by side.
    kinds : (m,) int64 array
        Encoding of each segment.
    begins : (m,) int64 array
        Begin of each segment in the data.
    rows : (m + 1,) int64 array
        First row of each segment, and the row after the last.
    words : (n, 7) uint64 array
        Out: bits of the poses; zero at first.
    """
    for segment in range(len(kinds)):
        row, count = rows[segment], rows[segment + 1] - rows[segment]
        if kinds[segment] == CHAIN:
            _read_chain(data, begins[segment], row, count, words)
        else:
            _read_planes(data, begins[segment], kinds[segment] == FLAT, row, count, words)


@compiled
def _read_chain(data: Bytes, begin: int, row: int, count: int, words: Words) -> None:
    width = _WIDTHS[data[begin]]
    step, x, y = _read(data, begin + 5, 4), _read(data, begin + 9, 8), _read(data, begin + 17, 8)
    at, available, bits = begin + 1 + HEAD, 0, 0
    for number in range(row, row + count):
        if available < width:
            bits |= int(data[at]) << available
            at, available = at + 1, available + 8
        code = bits & (1 << width) - 1
        bits, available = bits >> width, available - width
        if width == 3:
            code |= EXACT << 3
        direction = code & 7
        words[number, 0] = np.uint64(bits_of(x / PER_METRE) + (code >> 3 & 3) - 2)
        words[number, 1] = np.uint64(bits_of(y / PER_METRE) + (code >> 5 & 3) - 2)
        words[number, 5], words[number, 6] = _SINES[direction], _COSINES[direction]
        x, y = x + MOVES[direction, 0] * step, y + MOVES[direction, 1] * step


@compiled
def _read_planes(data: Bytes, begin: int, is_flat: bool, row: int, count: int, words: Words) -> None:
    at = begin
    for column in range(7):
        if is_flat and 2 <= column < 5:
            continue
        word = np.int64(0)
        for number in range(count):
            for plane in range(8):
                word += np.int64(data[at + plane * count + number]) << (8 * plane)
            words[row + number, column] = np.uint64(word)
        at += 8 * count


@compiled
def _write(out: Bytes, at: int, value: int, size: int) -> None:
    for place in range(size):
        out[at + place] = np.uint8(value >> (8 * place) & 255)


@compiled
def _read(data: Bytes, at: int, size: int) -> int:
    value = np.int64(0)
    for place in range(size):
        value |= np.int64(data[at + place]) << (8 * place)
    return int(value)


def warm() -> None:
    """Call the kernels once."""
    words, rows = np.zeros((1, 7), np.uint64), np.zeros(1, np.int64)
    words.flags.writeable = False
    write_chains(words, rows, rows + 1, np.empty(32, np.uint8), rows.copy())
    data = np.zeros(64, np.uint8)
    data.flags.writeable = False
    read_segments(data, rows + CHAIN, rows, np.arange(2), np.zeros((1, 7), np.uint64))
