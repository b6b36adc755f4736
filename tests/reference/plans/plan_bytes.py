"""Slow, obvious twins of plans as bytes, index keys and chunks, and of the cells that a path crosses."""

import itertools
import math
import struct

import numpy as np

from ppaas.maps.grid import GridInfo
from ppaas.plans.encoding.kernels.grid_moves import MOVES, QUATERNIONS

EDGE, SUBCELLS = 0.5, 64
_MASK = (1 << 64) - 1
_FACTORS = (
    0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9, 0xD6E8FEB86659FD93,
    0xA0761D6478BD642F, 0xE7037ED1A0B428DB, 0x8EBC6AF09C88C6E3,
)  # fmt: skip


def bits(value: float) -> int:
    """Return the bits of a float64 as a signed integer."""
    return struct.unpack("<q", struct.pack("<d", value))[0]


def float_of(word: int) -> float:
    """Return the float64 with these bits."""
    return struct.unpack("<d", struct.pack("<Q", word & _MASK))[0]


def waypoint_hash(pose) -> int:
    """Return the hash of a pose."""
    mixed = sum((bits(value) & _MASK) * factor for value, factor in zip(pose, _FACTORS, strict=True)) & _MASK
    mixed = (mixed ^ mixed >> 32) * 0xFF51AFD7ED558CCD & _MASK
    return mixed ^ mixed >> 32


def chain(poses) -> bytes | None:
    """Return the chain code of poses, or None if they do not move from cell to cell."""
    units = [[round(min(max(v, -1e6), 1e6) * 1e9) for v in pose[:2]] for pose in poses]
    ulps = [
        [bits(v) - bits(unit / 1e9) + 2 for v, unit in zip(pose, cell, strict=False)]
        for pose, cell in zip(poses, units, strict=True)
    ]
    headings = [bits(qz) for qz, _ in QUATERNIONS.tolist()]
    directions = [headings.index(bits(pose[5])) if bits(pose[5]) in headings else -1 for pose in poses]
    moved = [(b[0] - a[0], b[1] - a[1]) for a, b in itertools.pairwise(units)]
    step = max(map(abs, moved[0])) if moved else 0
    fits = step < 1 << 32 and all(0 <= value < 4 for values in ulps for value in values) and -1 not in directions
    fits = fits and all(
        bits(pose[6]) == bits(QUATERNIONS[direction, 1]) for pose, direction in zip(poses, directions, strict=True)
    )
    fits = fits and not any(bits(value) for pose in poses for value in pose[2:5])
    if not fits or any(
        move != tuple((MOVES[direction] * step).tolist()) for move, direction in zip(moved, directions, strict=False)
    ):
        return None
    encoded = bytes(direction | a << 3 | b << 5 for direction, (a, b) in zip(directions, ulps, strict=True))
    return b"\x01" + struct.pack("<IIqq", len(poses), step, *units[0]) + encoded


def number(data: bytes, expected: float) -> float:
    """Return the value of a tag and its bytes."""
    tag, code = data[0], int.from_bytes(data[1:], "little")
    unfolded = code >> 1 if not code & 1 else -(code + 1 >> 1)
    if tag < 7:
        return unfolded / 1e3
    if tag < 13:
        code, places = code >> 4, (code & 15) - 8
        return float_of(bits((code >> 1 if not code & 1 else -(code + 1 >> 1)) / 1e6) + places)
    return float_of(code) if tag == 15 else float_of(bits(expected) + code - (128 if tag == 13 else 1 << 15))


def tagged(data: bytes, count: int) -> dict[int, bytes]:
    """Return the tag and bytes of each number that differs from its prediction, by index."""
    mask = int.from_bytes(data[:3], "little")
    places = [place for place in range(count) if mask >> place & 1]
    tags = [data[3 + at // 2] >> 4 * (at & 1) & 15 for at in range(len(places))]
    at, encoded = 3 + (len(places) + 1) // 2, {}
    for place, tag in zip(places, tags, strict=True):
        size = {13: 1, 14: 2, 15: 8}.get(tag, tag if tag < 7 else tag - 4)
        encoded[place] = bytes((tag,)) + data[at : at + size]
        at += size
    return encoded


def mixed(scope: bytes, numbers) -> int:
    """Return a 64-bit hash."""
    word = int.from_bytes(scope[:8], "little")
    for value in numbers:
        word = (word ^ value & _MASK) * 0x9E3779B97F4A7C15 & _MASK
        word ^= word >> 29
    return word * 0xBF58476D1CE4E5B9 & _MASK


def index_key(scope: bytes, ends, length: float) -> int:
    """Return the index key of a plan, given x, y of both ends."""
    subcells = [math.floor(min(max(value / EDGE, -(2.0**40)), 2.0**40) * SUBCELLS) for value in ends]
    inside = 0
    for subcell in subcells:
        inside = inside << 6 | subcell % SUBCELLS
    bucket = mixed(scope, [subcell // SUBCELLS for subcell in subcells]) >> 64 - 21
    return (bucket << 18 | min(int(length * 16), (1 << 18) - 1)) << 24 | inside


def recipe(numbers) -> bytes:
    """Return numbers as bytes: the difference of each to the one before, in seven bits a byte."""
    data, before = bytearray(), 0
    for value in numbers:
        remaining = (value - before) << 1 if value >= before else ((before - value) << 1) - 1
        before = value
        while remaining >= 128:
            data.append(remaining & 127 | 128)
            remaining >>= 7
        data.append(remaining)
    return bytes(data)


def headings(yaw: float) -> tuple[float, float]:
    """Return qz, qw of a yaw."""
    return float(np.sin(yaw / 2)), float(np.cos(yaw / 2))


def may_join(ends, places, tolerance: float) -> bool:
    """Return whether the subcells of both ends come within a tolerance of two positions."""
    width = EDGE / SUBCELLS
    apart = []
    for end, place in zip(ends, places, strict=True):
        begin = math.floor(end / width) * width
        apart.append(max(begin - place, place - begin - width, 0.0))
    return max(math.hypot(*apart[:2]), math.hypot(*apart[2:])) <= tolerance


Cell = tuple[int, int]


def cells_on(info: GridInfo, points: list[list[float]], pieces: int = 1000) -> set[Cell]:
    """Return the cells of ``pieces`` points on each straight line of a path.

    Points on a border between cells, within rounding, do not count.
    """
    found = set()
    for (x0, y0), (x1, y1) in itertools.pairwise(points):
        fraction = np.linspace(0.0, 1.0, pieces + 1)
        line = np.stack((x0 + (x1 - x0) * fraction, y0 + (y1 - y0) * fraction), axis=1)
        off = 1e-6 * info.resolution
        nearby = [info.to_cells(line + shift) for shift in ((off, off), (-off, off), (off, -off), (-off, -off))]
        inside = np.all([np.all(each == nearby[0], axis=1) for each in nearby], axis=0)
        found |= {(row, column) for row, column in nearby[0][inside].tolist()}
    return found


def cuts(hashes: list[int], granularity: int) -> list[int]:
    """Return the waypoints before which a plan is cut: local maxima of the hashes, the last of equal ones."""
    first, last = 1, len(hashes) - 2
    if last - first < granularity:
        return []
    found = [first]
    for at in range(first + granularity, last - granularity):
        before = hashes[at - granularity : at]
        behind = hashes[at + 1 : at + granularity + 1]
        if hashes[at] >= max(before) and hashes[at] > max(behind):
            found.append(at)
    return [*found, last]


def near(first, last, start, goal, tolerance: float) -> bool:
    """Return whether both ends of a plan are near two positions."""
    return math.dist(first, start) <= tolerance and math.dist(last, goal) <= tolerance
