"""Stretches of waypoints as bytes.

The *code* of a stretch is made quickly, and equal stretches have equal codes: by it a stretch is known again. It is
*packed* once, when it is kept for the first time; a pack says by its first byte how it was made.
"""

import hashlib
import itertools
import zlib
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import Unavailable
from ppaas.geometry import Poses
from ppaas.plans.encoding.chain_code import chain_codes, chain_length, loose_chain, pack_chain, packed_length
from ppaas.plans.encoding.chunks import words_of
from ppaas.plans.encoding.kernels.chain_code import CHAIN, FLAT, SPATIAL, read_stretches

_CHAIN, _FLAT, _SPATIAL = bytes((CHAIN,)), bytes((FLAT,)), bytes((SPATIAL,))
_FLAT_COLUMNS = [0, 1, 5, 6]
_COLUMNS = {FLAT: 4, SPATIAL: 7}

ID_BYTES = 16


def codes_of(poses: Poses, begins: NDArray[np.int64], ends: NDArray[np.int64]) -> list[bytes]:
    """Return the codes of stretches of (n, 7) poses.

    Parameters
    ----------
    poses : (n, 7) float64 array
    begins, ends : (m,) array
        The rows of each stretch, from the first to behind the last.
    """
    codes = chain_codes(words_of(poses), begins, ends)
    others = [number for number, code in enumerate(codes) if not code]
    if others:
        flat = np.ascontiguousarray(poses[:, _FLAT_COLUMNS])
        in_space = (np.ascontiguousarray(poses[:, 2:5]).view(np.int64) != 0).any(axis=1)
    for number in others:
        rows = slice(begins[number], ends[number])
        spatial = in_space[rows].any()
        codes[number] = _SPATIAL + poses[rows].tobytes() if spatial else _FLAT + flat[rows].tobytes()
    return codes


def poses_of(code: bytes) -> Poses:
    """Return the (n, 7) poses of a code."""
    if code[:1] == _CHAIN:
        return poses_in([loose_chain(code)])
    if code[:1] == _SPATIAL:
        return np.frombuffer(code, "<f8", offset=1).reshape(-1, 7)
    flat = np.frombuffer(code, "<f8", offset=1).reshape(-1, 4)
    poses = np.zeros((len(flat), 7))
    poses[:, _FLAT_COLUMNS] = flat
    return poses


def waypoints_in(code: bytes) -> int:
    """Return how many waypoints a code has."""
    if code[:1] == _CHAIN:
        return chain_length(code)
    return (len(code) - 1) // (8 * (4 if code[:1] == _FLAT else 7))


def entry_id(scope: bytes, code: bytes) -> bytes:
    """Return the id of a stretch: what it is of, and what is in it.

    Parameters
    ----------
    scope : bytes
        16 bytes; equal stretches of another scope have another id.
    code : bytes
    """
    return hashlib.blake2b(code, digest_size=ID_BYTES, salt=scope).digest()


def pack(code: bytes) -> bytes:
    """Return what is kept of a code."""
    if code[:1] == _CHAIN:
        return pack_chain(code)
    columns = _COLUMNS[code[0]]
    words = np.frombuffer(code, "<i8", offset=1).reshape(-1, columns)
    # Neighbours are alike: what is told of each is how it differs, and bytes of equal weight lie side by side.
    moved = np.diff(words, axis=0, prepend=np.zeros((1, columns), "<i8"))
    planes = moved.view(np.uint8).reshape(len(words), columns * 8).T
    return code[:1] + zlib.compress(planes.tobytes(), 9, -15)


def unpack(data: bytes) -> bytes:
    """Return the code that was packed; ``Unavailable`` as `poses_in`."""
    poses = poses_in([data])
    [code] = codes_of(poses, np.array([0]), np.array([len(poses)]))
    return code


def poses_in(packs: Sequence[bytes]) -> Poses:
    """Return the (n, 7) poses of stretches that follow one another, as they are packed.

    Raises
    ------
    Unavailable
        One is damaged, or of a release that packed it otherwise.
    """
    try:
        told = [_told(data) for data in packs]
    except (LookupError, ValueError, zlib.error) as error:
        raise Unavailable(f"stored waypoints cannot be read ({error}): restore them from a backup") from error
    rows = np.array([0, *itertools.accumulate(count for count, _ in told)], np.int64)
    begins = np.array([0, *itertools.accumulate(len(data) for _, data in told)], np.int64)
    words = np.zeros((int(rows[-1]), 7), np.uint64)
    kinds = np.array([data[0] for data in packs], np.int64)
    read_stretches(np.frombuffer(b"".join([data for _, data in told]), np.uint8), kinds, begins, rows, words)
    return words.view(np.float64)


def _told(data: bytes) -> tuple[int, bytes]:
    """Return how many waypoints are packed, and what tells of them."""
    if data[0] == CHAIN:
        return packed_length(data), data[1:]
    width = 8 * _COLUMNS[data[0]]
    planes = zlib.decompress(data[1:], -15)
    if not planes or len(planes) % width:
        raise ValueError("a waypoint is cut off")
    return len(planes) // width, planes
