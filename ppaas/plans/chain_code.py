"""Waypoints on a grid as a chain code: where the first lies, and for each which of eight ways it heads.

H. Freeman, *On the encoding of arbitrary geometric configurations*, IRE Trans. Electronic Computers EC-10 (1961).
Coordinates are multiples of a nanometre, of which the nearest float64 is taken; those that were reckoned otherwise are
a unit in the last place or two beside it, which is told with the way. What comes back is what was given, bit for bit.
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Poses
from ppaas.plans.headings import MOVES, QUATERNIONS

PER_METRE = 1e9
_FARTHEST = 1e6
"""Coordinates up to which a nanometre is more than the last place of a float64 [m]."""

_HEADER = np.dtype([("count", "<u4"), ("step", "<u4"), ("x", "<i8"), ("y", "<i8")])
_WORDS = np.ascontiguousarray(QUATERNIONS).view(np.uint64)
_SINES, _COSINES = np.ascontiguousarray(_WORDS.T)
_MOVES = np.ascontiguousarray(MOVES.T)
_NONE = np.uint64(4)

_TO_WAY, _SIXTEENTH = np.uint64(0xC0C6848050B0787), np.uint64(60)
"""By which the eight sines have different products, seen by their highest four bits."""
_WAYS = np.zeros(16, np.int64)
_WAYS[(_WORDS[:, 0] * _TO_WAY) >> _SIXTEENTH] = np.arange(8)


def chain_codes(poses: Poses, begins: NDArray[np.int64], ends: NDArray[np.int64]) -> list[bytes | None]:
    """Return the codes of many stretches.

    Parameters
    ----------
    poses : (n, 7) float64 array
    begins, ends : (m,) array
        The rows of each stretch, from the first to behind the last; they ascend and do not overlap.

    Returns
    -------
    list
        For each stretch its code, or None if it is none of waypoints on a grid that follow one another.
    """
    if not len(begins):
        return []
    way, wrong = _ways(poses)
    places = np.ascontiguousarray(poses[:, :2].T)
    units, beside = _units(places)
    x, y = units
    wrong |= (beside[0] | beside[1]) >= 4
    moved = units[:, 1:] - units[:, :-1]
    steps = np.zeros(len(poses), np.int64)
    np.abs(moved).max(axis=0, out=steps[:-1])
    strays = np.zeros(len(poses), np.bool_)
    strays[:-1] = (moved != _MOVES[:, way[:-1]] * steps[:-1]).any(axis=0)
    strays[ends - 1] = False
    changes = np.zeros(len(poses), np.bool_)
    changes[1:] = steps[1:] != steps[:-1]
    changes[begins] = changes[ends - 1] = False
    wrong |= strays
    wrong |= changes
    wrongs = np.zeros(len(poses) + 1, np.int64)
    np.cumsum(wrong, out=wrongs[1:])
    step = steps[begins]
    fits = (wrongs[ends] == wrongs[begins]) & (step < 1 << 32)
    headers = np.zeros(len(begins), _HEADER)
    headers["count"], headers["step"] = ends - begins, np.where(fits & (ends - begins > 1), step, 0)
    headers["x"], headers["y"] = x[begins], y[begins]
    heads, size = headers.tobytes(), _HEADER.itemsize
    ways = (way | beside[0] << 3 | beside[1] << 5).astype(np.uint8).tobytes()
    return [
        heads[number * size : number * size + size] + ways[begin:end] if fit else None
        for number, (fit, begin, end) in enumerate(zip(fits.tolist(), begins.tolist(), ends.tolist(), strict=True))
    ]


def chain_poses(code: bytes) -> Poses:
    """Return the (n, 7) poses of a code."""
    header = np.frombuffer(code, _HEADER, 1)[0]
    ways = np.frombuffer(code, np.uint8, offset=_HEADER.itemsize).astype(np.int64)
    way = ways & 7
    units = np.empty((len(ways), 2), np.int64)
    units[0] = header["x"], header["y"]
    units[1:] = units[0] + np.cumsum(MOVES[way[:-1]], axis=0) * int(header["step"])
    poses = np.zeros((len(ways), 7))
    beside = np.stack((ways >> 3 & 3, ways >> 5 & 3), axis=1) - 2
    poses[:, :2] = ((units / PER_METRE).view(np.int64) + beside).view(np.float64)
    poses[:, 5:] = QUATERNIONS[way]
    return poses


def chain_length(code: bytes) -> int:
    """Return how many waypoints a code has."""
    return len(code) - _HEADER.itemsize


def shortened(code: bytes) -> bytes:
    """Return a code with three bits a waypoint, and four more where one lies beside its place."""
    ways = np.frombuffer(code, np.uint8, offset=_HEADER.itemsize)
    bits = np.unpackbits(ways[:, None], axis=1, bitorder="little")
    exact = bool((ways >> 3 == _EXACT).all())
    kept = bits[:, :3] if exact else bits[:, :7]
    return bytes((exact,)) + code[: _HEADER.itemsize] + np.packbits(kept, bitorder="little").tobytes()


def lengthened(data: bytes) -> bytes:
    """Return the code that was shortened."""
    exact, header = data[0], data[1 : 1 + _HEADER.itemsize]
    count, width = int(np.frombuffer(header, _HEADER)[0]["count"]), 3 if exact else 7
    packed = np.frombuffer(data, np.uint8, offset=1 + _HEADER.itemsize)
    bits = np.zeros((count, 8), np.uint8)
    bits[:, :width] = np.unpackbits(packed, count=count * width, bitorder="little").reshape(count, width)
    ways = np.packbits(bits, axis=1, bitorder="little").ravel()
    if exact:
        ways |= _EXACT << 3
    return header + ways.tobytes()


_EXACT = np.uint8(2 | 2 << 2)


def _units(metres: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the nanometres of coordinates, and how far beside them they lie: 2 is not at all, 0 to 3 can be told."""
    units = np.rint(np.minimum(np.maximum(metres, -_FARTHEST), _FARTHEST) * PER_METRE).astype(np.int64)
    beside = metres.view(np.int64) - (units / PER_METRE).view(np.int64)
    beside += 2
    # A negative one is large without its sign, and so no number from 0 to 3.
    return units, np.minimum(beside.view(np.uint64), _NONE).view(np.int64)


def _ways(poses: Poses) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Return for each pose the number of the way it heads, and whether it is none of the eight in the plane."""
    words = np.ascontiguousarray(poses).view(np.uint64)
    sine = np.ascontiguousarray(words[:, 5])
    way = _WAYS[(sine * _TO_WAY) >> _SIXTEENTH]
    wrong = (words[:, 2] | words[:, 3] | words[:, 4]) != 0
    return way, wrong | (sine != _SINES[way]) | (words[:, 6] != _COSINES[way])
