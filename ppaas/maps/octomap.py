"""OctoMap's files: binary (``.bt``) and full (``.ot``) octrees.

Both begin with a line that says which they are, lines ``id``, ``size`` (nodes), ``res`` (metres) in any order, among
them comments, and ``data``; the nodes follow at once.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap
from ppaas.maps.buffer import Buffer
from ppaas.maps.kernels import octree as kernels
from ppaas.maps.octree import OcTree, shared_depths

BINARY = b"# Octomap OcTree binary file"
FULL = b"# Octomap OcTree file"

EXTRA_BYTES = {b"OcTree": 0, b"ColorOcTree": 3}
"""What a node of each type has in a full file besides its log-odds and its children; in a binary one none has."""

_HEADER_LINES = 100
_FAULTS = {
    kernels.TRUNCATED: "the file ends before its tree does: it is not whole",
    kernels.TOO_DEEP: "the tree goes deeper than 16 levels",
    kernels.CHILDLESS: "an inner node has no children",
    kernels.TOO_MANY: "the tree has more nodes than its header says",
    kernels.NOT_A_NUMBER: "a node's log-odds are not a number",
}


@dataclass(frozen=True, slots=True)
class _Header:
    binary: bool
    kind: bytes
    size: int
    resolution: float


def parse_octomap(data: Buffer) -> OcTree:
    """Read a file, given as bytes or mapped into memory.

    Raises
    ------
    InvalidMap
        It is none, it ends too early, or it does not have the nodes that its header says.
    """
    header, body = _parse_header(data)
    nodes = np.frombuffer(body, np.uint8)
    if not header.size:
        return OcTree(header.resolution, np.empty((0, 3), np.uint16), np.empty(0, np.uint8), np.empty(0, np.bool_))
    # Each inner node of a binary file has at most 8 leaves in its two bytes; a leaf of a full one has five bytes.
    room = min(header.size, 4 * len(nodes) if header.binary else len(nodes) // 5)
    corners, depths, occupied = np.empty((room, 3), np.uint16), np.empty(room, np.uint8), np.empty(room, np.uint8)
    counts = np.zeros(2, np.int64)
    if header.binary:
        count = kernels.read_binary(nodes, corners, depths, occupied, counts)
    else:
        count = kernels.read_full(nodes, EXTRA_BYTES[header.kind], corners, depths, occupied, counts)
    if count < 0:
        raise InvalidMap(f"the octree cannot be read: {_FAULTS[count]}")
    if counts.tolist() != [header.size, len(nodes)]:
        raise InvalidMap(
            f"the octree has {counts[0]} nodes in {counts[1]} bytes; by its header it has {header.size}, "
            f"and the file {len(nodes)}"
        )
    known = slice(count)
    return OcTree(header.resolution, corners[known].copy(), depths[known].copy(), occupied[known].astype(np.bool_))


def binary_octomap(tree: OcTree) -> bytes:
    """Write a binary file (``.bt``).

    Raises
    ------
    InvalidMap
        The whole tree is one leaf, which such a file cannot tell.
    """
    if len(tree.depths) and not tree.depths.all():
        raise InvalidMap("a tree that is one leaf cannot be told in a binary file: split its root")
    nodes = tree.nodes
    body: NDArray[np.uint8] = np.zeros(2 * (nodes - len(tree.corners)), np.uint8)
    if nodes:
        kernels.write_binary(tree.corners, tree.depths, tree.occupied.view(np.uint8), shared_depths(tree.corners), body)
    return b"%b\nid OcTree\nsize %d\nres %b\ndata\n%b" % (BINARY, nodes, repr(tree.resolution).encode(), body.tobytes())


def _parse_header(data: Buffer) -> tuple[_Header, memoryview]:
    first, *lines = data[: 1 << 16].split(b"\n", _HEADER_LINES)
    if first.rstrip() not in (BINARY, FULL):
        raise InvalidMap(f"an OctoMap file begins with the line {BINARY.decode()!r} or {FULL.decode()!r}")
    words: dict[bytes, bytes] = {}
    length = len(first) + 1
    for line in lines:
        length += len(line) + 1
        key, _, value = line.strip().partition(b" ")
        if key == b"data":
            return _checked(first.rstrip() == BINARY, words), memoryview(data)[length:]
        if not key.startswith(b"#"):
            words[key] = value.strip()
    raise InvalidMap("the header of the OctoMap file does not end: there is no line 'data'")


def _checked(binary: bool, words: dict[bytes, bytes]) -> _Header:
    kind, size = words.get(b"id", b""), words.get(b"size", b"")
    if kind not in EXTRA_BYTES:
        known = " and ".join(name.decode() for name in EXTRA_BYTES)
        raise InvalidMap(f"octrees of type {kind.decode('ascii', 'replace')!r} are not read: {known} are")
    if not (size.isdigit() and len(size) < 16):
        raise InvalidMap(f"the octree's size is {size.decode('ascii', 'replace')!r}: a whole number of nodes")
    try:
        resolution = float(words.get(b"res", b""))
    except ValueError:
        resolution = math.nan
    if not (math.isfinite(resolution) and resolution > 0.0):
        raise InvalidMap("the octree's res must be a positive number of metres")
    return _Header(binary, kind, int(size), resolution)
