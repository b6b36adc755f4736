"""Segments of waypoints, and the poses of a path, as bytes, bit for bit.

The *code* of a segment is quick to compute, and equal segments have equal codes, so it identifies a segment. A code is
*packed* when the segment is first stored. The first byte of both names the encoding.

Waypoints from cell to cell have a chain code. A coordinate is stored as a multiple of a nanometre, whose nearest
float64 is taken. Coordinates that were computed differently lie one or two units in the last place beside it; that
offset is stored with the direction. Source: H. Freeman, *On the encoding of arbitrary geometric configurations*, IRE
Trans. Electronic Computers EC-10 (1961).

A packed path from cell to cell takes a byte a pose, where JSON takes 50, and any other path in the plane 32.
"""

import hashlib
import itertools
import struct
import zlib
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import MalformedMessage, Unavailable
from ppaas.geometry import Poses
from ppaas.plans.encoding.chunks import ENDS_AFTER, ENDS_BEFORE, words_of
from ppaas.plans.encoding.kernels.chain_code import CHAIN, EXACT, FLAT, HEAD, SPATIAL, read_segments, write_chains

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
    if data[0] == CHAIN:
        return packed_length(data), data[1:]
    width = 8 * _COLUMNS[data[0]]
    planes = zlib.decompress(data[1:], -15)
    if not planes or len(planes) % width:
        raise ValueError("a waypoint is truncated")
    return len(planes) // width, planes


# -- Freeman chain code of waypoints on a grid: the position of the first, and a direction for each --------------------

_COUNT = struct.Struct("<I")

_THREE_BITS, _SEVEN_BITS, _UNPACKED = b"\x01", b"\x00", b"\x02"
"""Packing of a code: three bits a waypoint; seven bits if some lie beside their grid position; or not packed."""


def chain_codes(words: NDArray[np.uint64], begins: NDArray[np.int64], ends: NDArray[np.int64]) -> list[bytes]:
    """Return the codes of many segments.

    Parameters
    ----------
    words : (n, 7) uint64 array
        Bits of poses.
    begins, ends : (m,) int64 array
        Rows of each segment, the end excluded.

    Returns
    -------
    list of bytes
        Code of each segment; empty if its waypoints are not consecutive cells of a grid.
    """
    stops = np.empty(len(begins), np.int64)
    out = np.empty(int((ends - begins).sum()) + (HEAD + 1) * len(begins), np.uint8)
    write_chains(words, begins, ends, out, stops)
    data, first, codes = out[: stops[-1] if len(stops) else 0].tobytes(), 0, []
    for stop in stops.tolist():
        codes.append(data[first:stop])
        first = stop
    return codes


def chain_length(code: bytes) -> int:
    """Return the number of waypoints of a code."""
    return len(code) - HEAD - 1


def pack_chain(code: bytes) -> bytes:
    """Return a code with three bits a waypoint, or seven if some lie beside their grid position."""
    directions = np.frombuffer(code, np.uint8, offset=1 + HEAD)
    bits = np.unpackbits(directions[:, None], axis=1, bitorder="little")
    exact = bool((directions >> 3 == EXACT).all())
    packed_bits = bits[:, :3] if exact else bits[:, :7]
    width_tag = _THREE_BITS if exact else _SEVEN_BITS
    return code[:1] + width_tag + code[1 : 1 + HEAD] + np.packbits(packed_bits, bitorder="little").tobytes()


def loose_chain(code: bytes) -> bytes:
    """Return a code in the packed format, without packing it."""
    return code[:1] + _UNPACKED + code[1:]


def packed_length(data: bytes) -> int:
    """Return the number of waypoints of a packed code.

    Raises
    ------
    ValueError
        It is not a chain code, or its length does not match its header.
    """
    if len(data) < 2 + HEAD or data[0] != CHAIN or data[1] > _UNPACKED[0]:
        raise ValueError("not a chain code")
    count, width = int(_COUNT.unpack_from(data, 2)[0]), {_THREE_BITS: 3, _SEVEN_BITS: 7, _UNPACKED: 8}[data[1:2]]
    if not count or len(data) != 2 + HEAD + (count * width + 7) // 8:
        raise ValueError("a chain code is truncated")
    return count


# -- poses of one path: its ends as they are, and those between them as a segment --------------------------------------

_POSE = 7 * 8
_ENDS = (ENDS_BEFORE + ENDS_AFTER) * _POSE
_FIRST = np.zeros(1, np.int64)
_CHAIN_ONLY = np.array([CHAIN], np.int64)


def pack_poses(poses: Poses) -> bytes:
    """Return (n, 7) poses as bytes."""
    poses = poses.astype("<f8", copy=False)
    if len(poses) <= ENDS_BEFORE + ENDS_AFTER:
        return poses.tobytes()
    [between] = codes_of(poses, np.array([ENDS_BEFORE]), np.array([len(poses) - ENDS_AFTER]))
    if between[0] == CHAIN:
        between = loose_chain(between)
    return b"".join((poses[:ENDS_BEFORE].tobytes(), poses[-ENDS_AFTER:].tobytes(), between))


def unpack_poses(data: bytes) -> Poses:
    """Return (n, 7) poses.

    Raises
    ------
    MalformedMessage
        The bytes are not packed poses.
    """
    between = data[_ENDS:]
    try:
        ends = np.frombuffer(data[:_ENDS], "<f8").reshape(-1, 7)
        if not between:
            return ends
        poses = _between(between)
    except ValueError as error:
        raise MalformedMessage(f"a path is not packed as it must be: {error}") from error
    poses[:ENDS_BEFORE], poses[-ENDS_AFTER:] = ends[:ENDS_BEFORE], ends[ENDS_BEFORE:]
    return poses


def _between(data: bytes) -> Poses:
    """Return the poses of a segment, with room for those before and after it; ``ValueError`` if there are none."""
    if data[0] != CHAIN:
        if data[0] not in (FLAT, SPATIAL):
            raise ValueError(f"no segment begins with {data[0]}")
        return np.pad(poses_of(data), ((ENDS_BEFORE, ENDS_AFTER), (0, 0)))
    count = packed_length(data)
    words = np.zeros((ENDS_BEFORE + count + ENDS_AFTER, 7), np.uint64)
    rows = np.array([ENDS_BEFORE, ENDS_BEFORE + count], np.int64)
    read_segments(np.frombuffer(data, np.uint8, offset=1), _CHAIN_ONLY, _FIRST, rows, words)
    return words.view(np.float64)
