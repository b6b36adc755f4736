"""Records: the checksummed pieces of which files and logs of mappings consist."""

import struct
import zlib
from collections.abc import Iterator
from enum import IntEnum
from typing import NamedTuple

from ppaas.errors import InvalidGraph

_HEAD = struct.Struct("<BxxxII")
"""Kind, length of the payload [bytes], and CRC-32 of kind, length and payload."""

MOST_PAYLOAD = 1 << 26
"""Largest payload [bytes]."""


class RecordKind(IntEnum):
    """Content of a record."""

    LASER = 1
    """Laser of all following scans; whatever was before belongs to another mapping."""
    FRAMES = 2
    """Key frames from an index on, each with the step from the one before; they replace the ones at these indices."""
    EDGES = 3
    """Edges that are not steps between successive key frames, from an index on; they replace the ones there."""
    POSES = 4
    """Poses of the first key frames, after a solve."""
    WAITING = 5
    """Closures that wait for others to agree with; replaces the last such record."""
    END = 6
    """End of a file: numbers of key frames and edges, and the CRC-32 of all before."""
    TIMES = 7
    """Times of scans of key frames; part of a log only."""


_KINDS = frozenset(RecordKind)


class Record(NamedTuple):
    """A record.

    Parameters
    ----------
    kind : RecordKind
    payload : memoryview or bytes
    """

    kind: RecordKind
    payload: memoryview | bytes


def pack_record(kind: RecordKind, payload: bytes) -> bytes:
    """Return the bytes of a record."""
    return _HEAD.pack(kind, len(payload), _checksum(kind, payload)) + payload


def unpack_records(data: memoryview | bytes) -> Iterator[tuple[int, Record]]:
    """Yield the records of some bytes, each with its offset [bytes].

    Raises
    ------
    InvalidGraph
        The bytes end within a record, or are damaged.
    """
    view, at = memoryview(data), 0
    while at < len(view):
        end = at + _HEAD.size
        if end > len(view):
            raise _cut_off(len(view))
        kind, length, checksum = _HEAD.unpack(view[at:end])
        if length > MOST_PAYLOAD or kind not in _KINDS:
            raise _damaged(at)
        payload = view[end : end + length]
        if len(payload) < length:
            raise _cut_off(len(view))
        if _checksum(kind, payload) != checksum:
            raise _damaged(at)
        yield at, Record(RecordKind(kind), payload)
        at = end + length


def _checksum(kind: int, payload: memoryview | bytes) -> int:
    return zlib.crc32(payload, zlib.crc32(struct.pack("<BI", kind, len(payload))))


def _cut_off(size: int) -> InvalidGraph:
    return InvalidGraph(f"the pose graph is cut off after {size} bytes: transfer or save it again")


def _damaged(at: int) -> InvalidGraph:
    return InvalidGraph(f"the pose graph is damaged at byte {at}: transfer or save it again")
