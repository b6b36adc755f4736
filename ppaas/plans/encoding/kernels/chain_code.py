"""Kernel: stretches of waypoints to chain codes, and from what is kept of stretches back to waypoints."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ppaas.plans.encoding.kernels.float_bits import bits_of, float_of
from ppaas.plans.encoding.kernels.grid_moves import MOVES, QUATERNIONS

Bytes = NDArray[np.uint8]
Words = NDArray[np.uint64]
Rows = NDArray[np.int64]

CHAIN, FLAT, SPATIAL = 1, 2, 3
"""How a stretch is told: as a chain code, by x, y and heading, or by all of its poses."""

HEAD = 24
"""Bytes of a chain code before its ways: how many, the step, x and y of the first."""

EXACT = 2 | 2 << 2
"""What is told of a waypoint that lies nowhere beside its place."""

PER_METRE = 1e9
_FARTHEST = 1e6
"""Coordinates up to which a nanometre is more than the last place of a float64 [m]."""

_SINES, _COSINES = np.ascontiguousarray(QUATERNIONS.view(np.uint64).T)
_TO_WAY, _SIXTEENTH = np.uint64(0xC0C6848050B0787), np.uint64(60)
"""By which the eight sines have different products, seen by their highest four bits."""
_WAYS = np.zeros(16, np.int64)
_WAYS[(_SINES * _TO_WAY) >> _SIXTEENTH] = np.arange(8)
_LONGEST = 1 << 32
_WIDTHS = np.array((7, 3, 8), np.int64)
"""Bits of a waypoint, by how it is packed."""


@njit(cache=True, nogil=True, error_model="numpy")
def _unit(word: np.uint64) -> int:
    """Return the nanometres of a coordinate, told by its bits."""
    return int(np.rint(min(max(float_of(np.int64(word)), -_FARTHEST), _FARTHEST) * PER_METRE))


@njit(cache=True, nogil=True, error_model="numpy")
def _beside(word: np.uint64, unit: int) -> int:
    """Return how many units in the last place a coordinate lies beside its nanometres: 2 is none."""
    return int(np.int64(word)) - bits_of(unit / PER_METRE) + 2


@njit(cache=True, nogil=True, error_model="numpy")
def _told(words: Words, row: int, x: int, y: int) -> int:
    """Return the byte that tells of a waypoint: where it heads, and how its place lies; -1 if it cannot."""
    sine = words[row, 5]
    way = _WAYS[(sine * _TO_WAY) >> _SIXTEENTH]
    if sine != _SINES[way] or words[row, 6] != _COSINES[way] or words[row, 2] | words[row, 3] | words[row, 4] != 0:
        return -1
    beside_x, beside_y = _beside(words[row, 0], x), _beside(words[row, 1], y)
    if not 0 <= beside_x < 4 or not 0 <= beside_y < 4:
        return -1
    return int(way | beside_x << 3 | beside_y << 5)


@njit(cache=True, nogil=True, error_model="numpy")
def write_chains(words: Words, begins: Rows, ends: Rows, out: Bytes, stops: Rows) -> None:
    """Write the chain codes of stretches of (n, 7) poses, told by their bits.

    Parameters
    ----------
    words : (n, 7) array
    begins, ends : (m,) array
        The rows of each stretch.
    out : (k,) array
        Gets the codes: so many bytes as waypoints, and `HEAD` and one for each stretch.
    stops : (m,) array
        Gets where the code of each stretch ends; there is none where it does not run from cell to cell.
    """
    at = 0
    for stretch in range(len(begins)):
        begin, end = begins[stretch], ends[stretch]
        head = at
        at += HEAD + 1
        x, y = _unit(words[begin, 0]), _unit(words[begin, 1])
        out[head] = CHAIN
        _write(out, head + 1, end - begin, 4)
        _write(out, head + 9, x, 8)
        _write(out, head + 17, y, 8)
        step = 0
        if end - begin > 1:
            step = max(abs(_unit(words[begin + 1, 0]) - x), abs(_unit(words[begin + 1, 1]) - y))
        _write(out, head + 5, step, 4)
        fits = step < _LONGEST
        for row in range(begin, end):
            told = _told(words, row, x, y)
            if told < 0 or not fits:
                fits = False
                break
            out[at] = told
            at += 1
            if row + 1 < end:
                way = told & 7
                was_x, was_y = x, y
                x, y = _unit(words[row + 1, 0]), _unit(words[row + 1, 1])
                fits = x - was_x == MOVES[way, 0] * step and y - was_y == MOVES[way, 1] * step
        if not fits:
            at = head
        stops[stretch] = at


@njit(cache=True, nogil=True, error_model="numpy")
def read_stretches(data: Bytes, kinds: Rows, begins: Rows, rows: Rows, words: Words) -> None:
    """Write the waypoints of stretches.

    Parameters
    ----------
    data : (k,) array
        What tells of them: of a chain what is packed of it; else the bytes of the differences from waypoint to
        waypoint, all of equal weight side by side.
    kinds : (m,) array
        How each is told.
    begins : (m,) array
        Where in the data each begins.
    rows : (m + 1,) array
        Where its waypoints begin.
    words : (n, 7) array
        Gets the bits of the poses; must be zero.
    """
    for stretch in range(len(kinds)):
        row, count = rows[stretch], rows[stretch + 1] - rows[stretch]
        if kinds[stretch] == CHAIN:
            _read_chain(data, begins[stretch], row, count, words)
        else:
            _read_planes(data, begins[stretch], kinds[stretch] == FLAT, row, count, words)


@njit(cache=True, nogil=True, error_model="numpy")
def _read_chain(data: Bytes, begin: int, row: int, count: int, words: Words) -> None:
    width = _WIDTHS[data[begin]]
    step, x, y = _read(data, begin + 5, 4), _read(data, begin + 9, 8), _read(data, begin + 17, 8)
    at, held, bits = begin + 1 + HEAD, 0, 0
    for number in range(row, row + count):
        if held < width:
            bits |= int(data[at]) << held
            at, held = at + 1, held + 8
        told = bits & (1 << width) - 1
        bits, held = bits >> width, held - width
        if width == 3:
            told |= EXACT << 3
        way = told & 7
        words[number, 0] = np.uint64(bits_of(x / PER_METRE) + (told >> 3 & 3) - 2)
        words[number, 1] = np.uint64(bits_of(y / PER_METRE) + (told >> 5 & 3) - 2)
        words[number, 5], words[number, 6] = _SINES[way], _COSINES[way]
        x, y = x + MOVES[way, 0] * step, y + MOVES[way, 1] * step


@njit(cache=True, nogil=True, error_model="numpy")
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


@njit(cache=True, nogil=True, error_model="numpy")
def _write(out: Bytes, at: int, value: int, size: int) -> None:
    for place in range(size):
        out[at + place] = np.uint8(value >> (8 * place) & 255)


@njit(cache=True, nogil=True, error_model="numpy")
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
    read_stretches(data, rows + CHAIN, rows, np.arange(2), np.zeros((1, 7), np.uint64))
