"""Segments of waypoints as bytes.

The *code* of a segment is quick to compute, and equal segments have equal codes, so it identifies a segment. A code is
*packed* when the segment is first stored. The first byte of both names the encoding.
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
from ppaas.plans.encoding.kernels.chain_code import CHAIN, FLAT, SPATIAL, read_segments

_CHAIN, _FLAT, _SPATIAL = bytes((CHAIN,)), bytes((FLAT,)), bytes((SPATIAL,))
_FLAT_COLUMNS = [0, 1, 5, 6]
_COLUMNS = {FLAT: 4, SPATIAL: 7}

ID_BYTES = 16
"""Length of the id of an entry [bytes]."""


def codes_of(poses: Poses, begins: NDArray[np.int64], ends: NDArray[np.int64]) -> list[bytes]:
    """Return the codes of segments of (n, 7) poses.

    Parameters
    ----------
    poses : (n, 7) float64 array
        Poses of all segments.
    begins, ends : (m,) int64 array
        Rows of each segment, the end excluded.
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
    """Return the number of waypoints of a code."""
    if code[:1] == _CHAIN:
        return chain_length(code)
    return (len(code) - 1) // (8 * (4 if code[:1] == _FLAT else 7))


def entry_id(scope: bytes, code: bytes) -> bytes:
    """Return the id of a segment: a hash of its scope and content.

    Parameters
    ----------
    scope : bytes
        16 bytes of the map version; equal segments of different scopes have different ids.
    code : bytes
        Code of the segment.
    """
    return hashlib.blake2b(code, digest_size=ID_BYTES, salt=scope).digest()


def pack(code: bytes) -> bytes:
    """Return the packed form of a code, as it is stored."""
    if code[:1] == _CHAIN:
        return pack_chain(code)
    columns = _COLUMNS[code[0]]
    words = np.frombuffer(code, "<i8", offset=1).reshape(-1, columns)
    # Neighbours are similar: store differences, with bytes of equal significance side by side, which compress well.
    differences = np.diff(words, axis=0, prepend=np.zeros((1, columns), "<i8"))
    planes = differences.view(np.uint8).reshape(len(words), columns * 8).T
    return code[:1] + zlib.compress(planes.tobytes(), 9, -15)


def unpack(data: bytes) -> bytes:
    """Return the code of a packed segment; raises as `poses_in`."""
    poses = poses_in([data])
    [code] = codes_of(poses, np.array([0]), np.array([len(poses)]))
    return code


def poses_in(packs: Sequence[bytes]) -> Poses:
    """Return the (n, 7) poses of packed segments, one after the other.

    Raises
    ------
    Unavailable
        A segment is damaged, or another release packed it in another format.
    """
    try:
        payloads = [_payload(data) for data in packs]
    except (LookupError, ValueError, zlib.error) as error:
        raise Unavailable(f"stored waypoints cannot be read ({error}): restore them from a backup") from error
    rows = np.array([0, *itertools.accumulate(count for count, _ in payloads)], np.int64)
    begins = np.array([0, *itertools.accumulate(len(data) for _, data in payloads)], np.int64)
    words = np.zeros((int(rows[-1]), 7), np.uint64)
    kinds = np.array([data[0] for data in packs], np.int64)
    read_segments(np.frombuffer(b"".join([data for _, data in payloads]), np.uint8), kinds, begins, rows, words)
    return words.view(np.float64)


def _payload(data: bytes) -> tuple[int, bytes]:
    """Return the number of waypoints of a packed segment, and its bytes for the kernel."""
    if data[0] == CHAIN:
        return packed_length(data), data[1:]
    width = 8 * _COLUMNS[data[0]]
    planes = zlib.decompress(data[1:], -15)
    if not planes or len(planes) % width:
        raise ValueError("a waypoint is truncated")
    return len(planes) // width, planes
