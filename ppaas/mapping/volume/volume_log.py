"""Log of a 3D map: pages of its blocks, each replaced when it changes, and a head that says where they are.

While the map consists of submaps, the log has the pages of these, and the volume is put together from them again.
Otherwise it has the volume's blocks. So a log is at most about as large as its map, compressed.
"""

import struct
import zlib
from collections.abc import Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray

from ppaas.bounded import inflated
from ppaas.change_log import LogChange, LogEntry
from ppaas.decoding import from_json
from ppaas.errors import InvalidMap
from ppaas.geometry import Pose2D
from ppaas.mapping.volume.blocks import PAGE, VoxelBlocks
from ppaas.mapping.volume.kernels.blocks import VOXELS
from ppaas.mapping.volume.key_frame_poses import KeyFramePoses
from ppaas.mapping.volume.submap import VolumeSubmap
from ppaas.mapping.volume.submap_volume import SubmapVolume

LEVEL = 1
"""Compression level of zlib."""

VOLUME = 0
"""Number of the volume among the parts of a map; submaps have numbers from 1."""

_PAGE = struct.Struct("<4xIIII")
"""Zeros, number of the part, index of the page, number of blocks, and CRC-32 of what follows."""

HEAD = b"{"
"""First byte of a head, which is JSON; pages begin with zeros."""

Triple = tuple[float, float, float]


class Part(msgspec.Struct, frozen=True, array_like=True):
    """Submap, or the volume.

    Parameters
    ----------
    number : int
    blocks : int
        Number of its blocks.
    stamp : float
        Time of its key frame [s].
    motion : tuple of float
        Its motion in the map frame since its clouds were inserted.
    key_frame : tuple of float
        Pose of the robot at its key frame.
    """

    number: int
    blocks: int
    stamp: float = 0.0
    motion: Triple = (0.0, 0.0, 0.0)
    key_frame: Triple = (0.0, 0.0, 0.0)


class VolumeHead(msgspec.Struct, frozen=True):
    """State of a map without its voxels.

    Parameters
    ----------
    resolution : float
        Edge of a voxel [m].
    parts : tuple of Part
    joined : int
    fixed : bool
        See `SubmapVolume`.
    """

    resolution: float
    parts: tuple[Part, ...]
    joined: int = 0
    fixed: bool = False


class VolumeLogWriter:
    """Writes the log of a map."""

    def __init__(self) -> None:
        self._next = 0
        self._pages: dict[tuple[int, int], int] = {}
        self._head: tuple[bytes, int | None] = b"", None
        self._stale: list[int] = []

    def write(self, map_: SubmapVolume, key_frames: KeyFramePoses) -> LogChange | None:
        """Return the change of the log since the last call; None if there is none.

        Parameters
        ----------
        map_ : SubmapVolume
        key_frames : KeyFramePoses
            Key frames at whose poses the map is.
        """
        entries: list[LogEntry] = []
        parts = parts_of(map_)
        wanted = {(number, page) for number, part in parts.items() for page in range(part.pages)}
        self._stale += [self._pages.pop(key) for key in self._pages.keys() - wanted]
        for number, part in parts.items():
            changed, codes = part.take_changed(), part.codes
            for page in range(part.pages):
                if page in changed or (number, page) not in self._pages:
                    self._replace((number, page), pack_page(number, page, codes, part.log_odds), entries)
        self._write_head(map_, key_frames, entries)
        obsolete, self._stale = self._stale, []
        return LogChange(entries, obsolete) if entries or obsolete else None

    def take_over(self, entries: Sequence[LogEntry], map_: SubmapVolume | None) -> None:
        """Continue a log from which a map was read; None if it could not be, so that all entries are obsolete."""
        self._next = max((entry.number for entry in entries), default=-1) + 1
        self._pages, self._head, self._stale = {}, (b"", None), []
        if map_ is None:
            self._stale = [entry.number for entry in entries]
            return
        for number, data in entries:
            if data[:1] == HEAD:
                self._stale += [] if self._head[1] is None else [self._head[1]]
                self._head = data, number
            else:
                part, page, _ = _page(data)
                if (part, page) in self._pages:
                    self._stale.append(self._pages[part, page])
                self._pages[part, page] = number
        for blocks in parts_of(map_).values():
            blocks.take_changed()

    def _replace(self, key: tuple[int, int], data: bytes, entries: list[LogEntry]) -> None:
        before = self._pages.get(key)
        if before is not None:
            self._stale.append(before)
        self._pages[key] = self._append(data, entries)

    def _write_head(self, map_: SubmapVolume, key_frames: KeyFramePoses, entries: list[LogEntry]) -> None:
        head = msgspec.json.encode(head_of(map_, key_frames)) if self._pages else b""
        data, number = self._head
        if head == data:
            return
        self._stale += [] if number is None else [number]
        self._head = head, self._append(head, entries) if head else None

    def _append(self, data: bytes, entries: list[LogEntry]) -> int:
        entries.append(LogEntry(self._next, data))
        self._next += 1
        return self._next - 1


def parts_of(map_: SubmapVolume) -> dict[int, VoxelBlocks]:
    """Return the parts of a map whose voxels its log has, by their numbers."""
    return {submap.number: submap.blocks for submap in map_.submaps} or {VOLUME: map_.volume.blocks}


def head_of(map_: SubmapVolume, key_frames: KeyFramePoses) -> VolumeHead:
    """Return the head of a map at the poses of key frames."""
    parts = [
        Part(
            submap.number, len(submap.blocks), submap.stamp, _triple(submap.motion),
            _triple(key_frames.anchor(submap.stamp).pose if len(key_frames) else Pose2D(0.0, 0.0, 0.0)),
        )
        for submap in map_.submaps
    ]  # fmt: skip
    whole = [Part(VOLUME, len(map_.volume.blocks))]
    return VolumeHead(map_.volume.parameters.resolution, tuple(parts or whole), map_.joined, map_.fixed)


def pack_page(number: int, page: int, codes: NDArray[np.int64], log_odds: NDArray[np.float32]) -> bytes:
    """Return the entry of a page of a part with codes (n,) and log-odds (n, 512).

    Few values are different, so the page has a table of these, and their indices.
    """
    rows = slice(page * PAGE, (page + 1) * PAGE)
    values, indices = np.unique(log_odds[rows].astype("<f4").view("<u4"), return_inverse=True)
    count = struct.pack("<I", len(values))
    table = values.astype("<u4").tobytes() + indices.astype(_index_type(len(values))).tobytes()
    data = zlib.compress(count + codes[rows].astype("<i8").tobytes() + table, LEVEL)
    return _PAGE.pack(number, page, len(codes[rows]), zlib.crc32(data)) + data


def read_log(entries: Sequence[LogEntry], map_: SubmapVolume) -> KeyFramePoses:
    """Fill an empty map from a log; return the key frames of its submaps, at whose poses it is.

    Parameters
    ----------
    entries : sequence of LogEntry
        All entries, in the order of their numbers.
    map_ : SubmapVolume

    Raises
    ------
    InvalidMap
        An entry is damaged or missing, or the map has another resolution.
    QuotaExceeded
        There are more blocks than allowed.
    """
    pages: dict[tuple[int, int], memoryview] = {}
    head: VolumeHead | None = None
    for _, data in entries:
        if data[:1] == HEAD:
            head = _head(data)
        else:
            number, page, view = _page(data)
            pages[number, page] = view
    if head is None:
        raise InvalidMap("the log of the 3D map has no head: map the place again")
    own = map_.volume.parameters
    if head.resolution != own.resolution:
        raise InvalidMap(f"the 3D map has voxels of {head.resolution:g} m, not {own.resolution:g}: map the place again")
    parts = {part.number: _blocks(part, pages, own.max_blocks * (1 + (part.number != VOLUME))) for part in head.parts}
    if VOLUME in parts:
        map_.resume([], parts[VOLUME], joined=head.joined, fixed=head.fixed)
        return KeyFramePoses(np.empty(0), np.empty((0, 3)))
    submaps = [
        VolumeSubmap.of(part.number, part.stamp, Pose2D(*part.motion), parts[part.number]) for part in head.parts
    ]
    map_.resume(submaps, None, joined=head.joined, fixed=head.fixed)
    stamps, first = np.unique([part.stamp for part in head.parts], return_index=True)
    return KeyFramePoses(stamps, np.array([head.parts[index].key_frame for index in first]))


def _head(data: bytes) -> VolumeHead:
    try:
        return from_json(data, VolumeHead)
    except msgspec.DecodeError as error:
        raise InvalidMap(f"the log of the 3D map is damaged: {error}") from error


def _page(data: bytes) -> tuple[int, int, memoryview]:
    view = memoryview(data)
    if len(view) < _PAGE.size:
        raise _damaged()
    number, page, _, checksum = _PAGE.unpack_from(view)
    if zlib.crc32(view[_PAGE.size :]) != checksum:
        raise _damaged()
    return number, page, view


def _blocks(part: Part, pages: dict[tuple[int, int], memoryview], most: int) -> VoxelBlocks:
    """Return the blocks of a part, in the order of their slots."""
    blocks = VoxelBlocks(most)
    for page in range(-(-part.blocks // PAGE)):
        if (part.number, page) not in pages:
            raise InvalidMap("the log of the 3D map lacks a page: map the place again")
        codes, log_odds = _unpacked(pages[part.number, page])
        slots = blocks.add(codes)
        blocks.log_odds[slots] = log_odds
    if len(blocks) < part.blocks:
        raise _damaged()
    return blocks


def _unpacked(page: memoryview) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Return the codes (n,) and the log-odds (n, 512) of a page whose checksum is right."""
    count = min(_PAGE.unpack_from(page)[2], PAGE)
    try:
        data = inflated(page[_PAGE.size :], 4 + count * (8 + 6 * VOXELS))
        different = np.frombuffer(data, "<u4", 1)[0]
        codes = np.frombuffer(data, "<i8", count, 4).astype(np.int64)
        values = np.frombuffer(data, "<u4", different, 4 + 8 * count)
        indices = np.frombuffer(data, _index_type(different), -1, 4 + 8 * count + 4 * different)
        return codes, values[indices.reshape(count, VOXELS)].view(np.float32)
    except (ValueError, IndexError, zlib.error, OverflowError) as error:
        raise _damaged() from error


def _index_type(different: int) -> str:
    """Return the type of indices into a table with this number of values; a page has at most 2**15."""
    return "<u1" if different <= 1 << 8 else "<u2"


def _triple(pose: Pose2D) -> Triple:
    return pose.x, pose.y, pose.theta


def _damaged() -> InvalidMap:
    return InvalidMap("the log of the 3D map is damaged: map the place again")
