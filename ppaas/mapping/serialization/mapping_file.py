"""Files of mappings: key frames, pose graph and laser as bytes, compact and checksummed."""

import struct
import zlib
from collections.abc import Iterator

from ppaas.errors import InvalidGraph
from ppaas.mapping.serialization.mapping import Mapping, pack_laser
from ppaas.mapping.serialization.rebuilding import MOST_BYTES, Rebuilding
from ppaas.mapping.serialization.records import RecordKind, pack_record, unpack_records
from ppaas.mapping.serialization.rows import packed_rows

MAGIC = b"PPaaS posegraph "
"""First bytes of a file, before the number of its format."""

FORMAT = 1
"""Number of the format."""

_START = struct.Struct(f"<{len(MAGIC)}sI")

_END = struct.Struct("<III")
"""Numbers of key frames and edges, and the CRC-32 of all bytes before this record."""


def pack_mapping(mapping: Mapping) -> Iterator[bytes]:
    """Yield the bytes of a file, piece by piece. Its waiting closures are not part of it.

    A beam takes about 3 bytes. Points are rounded to 0.25 mm below 16 m, normals to 0.8 mrad, and information matrices
    to float32; poses and measurements are exact. The bytes of a file that was read and is packed again are the same.

    Parameters
    ----------
    mapping : Mapping
        At least one key frame.
    """
    checksum = 0
    for piece in _pieces(mapping):
        checksum = zlib.crc32(piece, checksum)
        yield piece
    yield pack_record(RecordKind.END, _END.pack(len(mapping.frames), mapping.graph.edge_count, checksum))


def unpack_mapping(data: memoryview | bytes, most_bytes: int = MOST_BYTES) -> Mapping:
    """Return the mapping of a file.

    Parameters
    ----------
    data : bytes-like
        Whole file; may be a memory map.
    most_bytes : int
        Memory that the mapping may take [bytes].

    Raises
    ------
    InvalidGraph
        It is not such a file, it is cut off or damaged, or its parts contradict each other.
    QuotaExceeded
        The mapping would take more memory than allowed.
    """
    view = memoryview(data)
    _check_start(view)
    rebuilt, end = Rebuilding(most_bytes), None
    for at, record in unpack_records(view[_START.size :]):
        if end is not None:
            raise InvalidGraph("the pose graph has data after its end: transfer or save it again")
        if record.kind == RecordKind.WAITING:
            raise InvalidGraph("the pose graph has closures that wait, which only a log may have: save it again")
        if record.kind == RecordKind.END:
            end = _checked_end(record.payload, zlib.crc32(view[: _START.size + at]))
        else:
            rebuilt.add(record)
    if end is None:
        raise InvalidGraph(f"the pose graph is cut off after {len(view)} bytes: transfer or save it again")
    mapping = rebuilt.mapping()
    found = len(mapping.frames), mapping.graph.edge_count
    if found != end:
        raise InvalidGraph(f"the pose graph has {found[0]} key frames and {found[1]} edges, not {end[0]} and {end[1]}")
    return mapping


def is_mapping(data: memoryview | bytes) -> bool:
    """Return whether data begin as a file of a mapping."""
    return bytes(data[: len(MAGIC)]) == MAGIC


def _pieces(mapping: Mapping) -> Iterator[bytes]:
    """Yield the bytes of a file but its last record."""
    yield _START.pack(MAGIC, FORMAT)
    yield pack_laser(mapping.frames.geometry, mapping.laser_frame)
    yield from packed_rows(mapping.frames, mapping.graph)


def _check_start(view: memoryview) -> None:
    if not is_mapping(view) or len(view) < _START.size:
        raise InvalidGraph("this is not a pose graph of PPaaS: get one with 'ppaas map fetch' or 'serialize_map'")
    number = _START.unpack(view[: _START.size])[1]
    if number != FORMAT:
        raise InvalidGraph(f"the pose graph has format {number}; this release reads format {FORMAT}")


def _checked_end(payload: memoryview | bytes, checksum: int) -> tuple[int, int]:
    """Return the numbers of key frames and edges of the last record."""
    if len(payload) != _END.size:
        raise InvalidGraph("the last record of the pose graph cannot be read: save it again")
    frames, edges, expected = _END.unpack(payload)
    if expected != checksum:
        raise InvalidGraph("records of the pose graph are missing or mixed up: transfer or save it again")
    return frames, edges
