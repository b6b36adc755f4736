"""OctoMap files: reading and writing of binary (``.bt``) and full (``.ot``) octrees.

Both begin with a line that names the format. The lines ``id``, ``size`` (number of nodes) and ``res`` (metres) follow
in any order, possibly with comments, then the line ``data`` and immediately the nodes.
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

EXTRA_BYTES = {b"OcTree": 0, b"ColorOcTree": 3, b"OcTreeStamped": 0, b"1": 0}
"""Bytes per node of each tree type in a full file besides log-odds and children; binary files have none.

OctoMap writes no time stamps of an ``OcTreeStamped``, and takes the id ``1`` of its first releases for ``OcTree``.
Trees without occupancies (``CountingOcTree``) are not read.
"""

_COMMENT = b"# (feel free to add / change comments, but leave the first line as it is!)"
_NODE = np.dtype([("log_odds", "<f4"), ("children", "u1")])
_HEADER_LINES = 100
_FAULTS = {
    kernels.TRUNCATED: "the file is truncated",
    kernels.TOO_DEEP: "the tree is deeper than 16 levels",
    kernels.CHILDLESS: "an inner node has no children",
    kernels.TOO_MANY: "the tree has more nodes than its header states",
    kernels.NOT_A_NUMBER: "the log-odds of a node are not a number",
}


@dataclass(frozen=True, slots=True)
class _Header:
    binary: bool
    kind: bytes
    size: int
    resolution: float


def parse_octomap(data: Buffer) -> OcTree:
    """Read an OctoMap file, given as bytes or memory-mapped.

    Raises
    ------
    InvalidMap
        It is not an OctoMap file, it is truncated, or its nodes do not match its header.
    """
    header, body = _parse_header(data)
    nodes = np.frombuffer(body, np.uint8)
    if not header.size:
        return OcTree(header.resolution, np.empty((0, 3), np.uint16), np.empty(0, np.uint8), np.empty(0, np.bool_))
    # Upper bound of the number of leaves: an inner node of a binary file takes two bytes and has at most 8 leaves; a
    # leaf of a full file takes at least five bytes.
    most = min(header.size, 4 * len(nodes) if header.binary else len(nodes) // 5)
    corners, depths, occupied = np.empty((most, 3), np.uint16), np.empty(most, np.uint8), np.empty(most, np.uint8)
    counts = np.zeros(2, np.int64)
    if header.binary:
        count = kernels.read_binary(nodes, corners, depths, occupied, counts)
    else:
        count = kernels.read_full(nodes, EXTRA_BYTES[header.kind], corners, depths, occupied, counts)
    if count < 0:
        raise InvalidMap(f"the octree cannot be read: {_FAULTS[count]}")
    if counts.tolist() != [header.size, len(nodes)]:
        raise InvalidMap(
            f"the octree has {counts[0]} nodes in {counts[1]} bytes, but its header states {header.size} nodes and "
            f"the file has {len(nodes)} bytes after the header"
        )
    used = slice(count)
    return OcTree(header.resolution, corners[used].copy(), depths[used].copy(), occupied[used].astype(np.bool_))


def binary_octomap(tree: OcTree) -> bytes:
    """Return the binary OctoMap file (``.bt``) of an octree.

    Raises
    ------
    InvalidMap
        The root is a leaf, which the format cannot represent.
    """
    if len(tree.depths) and not tree.depths.all():
        raise InvalidMap(
            "the root is one leaf, which a binary OctoMap file cannot represent: split it into its children"
        )
    nodes = tree.nodes
    body: NDArray[np.uint8] = np.zeros(2 * (nodes - len(tree.corners)), np.uint8)
    if nodes:
        kernels.write_binary(tree.corners, tree.depths, tree.occupied.view(np.uint8), shared_depths(tree.corners), body)
    return _header_text(BINARY, tree) + body.tobytes()


def full_octomap(tree: OcTree, log_odds: NDArray[np.float32]) -> bytes:
    """Return the full OctoMap file (``.ot``) of an octree.

    Parameters
    ----------
    tree : OcTree
        The octree.
    log_odds : (n,) float32 array
        Log-odds of its leaves.
    """
    nodes: NDArray[np.void] = np.zeros(tree.nodes, _NODE)
    if tree.nodes:
        values, children = np.empty(tree.nodes, np.float32), np.zeros(tree.nodes, np.uint8)
        kernels.number_nodes(tree.corners, tree.depths, log_odds, shared_depths(tree.corners), values, children)
        nodes["log_odds"], nodes["children"] = values, children
    return _header_text(FULL, tree) + nodes.tobytes()


def octomap_nodes(data: Buffer) -> memoryview:
    """Return the nodes of an OctoMap file, which follow its header: the data of ``octomap_msgs/Octomap``.

    Raises
    ------
    InvalidMap
        It is not an OctoMap file.
    """
    return _parse_header(data)[1]


def _header_text(first: bytes, tree: OcTree) -> bytes:
    """Return the header of a file, byte by byte as OctoMap writes it, unless six digits would change the resolution."""
    short = f"{tree.resolution:g}"
    resolution = short if float(short) == tree.resolution else repr(tree.resolution)
    lines = (first, _COMMENT, b"#", b"id OcTree", b"size %d" % tree.nodes, b"res " + resolution.encode(), b"data", b"")
    return b"\n".join(lines)


def _parse_header(data: Buffer) -> tuple[_Header, memoryview]:
    first, *lines = data[: 1 << 16].split(b"\n", _HEADER_LINES)
    if first.rstrip() not in (BINARY, FULL):
        raise InvalidMap(f"not an OctoMap file: it must begin with the line {BINARY.decode()!r} or {FULL.decode()!r}")
    words: dict[bytes, bytes] = {}
    length = len(first) + 1
    for line in lines:
        length += len(line) + 1
        key, _, value = line.strip().partition(b" ")
        if key == b"data":
            return _header_of(first.rstrip() == BINARY, words), memoryview(data)[length:]
        if not key.startswith(b"#"):
            words[key] = value.strip()
    raise InvalidMap("the header of the OctoMap file has no end: the line 'data' is missing")


def _header_of(binary: bool, words: dict[bytes, bytes]) -> _Header:
    kind, size = words.get(b"id", b""), words.get(b"size", b"")
    if kind not in EXTRA_BYTES:
        known = ", ".join(name.decode() for name in EXTRA_BYTES if name.isalpha())
        raise InvalidMap(f"unsupported octree type {kind.decode('ascii', 'replace')!r}; supported: {known}")
    if not (size.isdigit() and len(size) < 16):
        text = size.decode("ascii", "replace")
        raise InvalidMap(f"'size' in the octree's header must be a whole number of nodes, not {text!r}")
    try:
        resolution = float(words.get(b"res", b""))
    except ValueError:
        resolution = math.nan
    if not (math.isfinite(resolution) and resolution > 0.0):
        raise InvalidMap("'res' in the octree's header must be a positive number of metres")
    return _Header(binary, kind, int(size), resolution)
