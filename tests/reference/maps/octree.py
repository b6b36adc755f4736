"""Slow, obvious twins of the octree's kernels: recursion over nodes, as in OctoMap's own reader and writer."""

import struct

import numpy as np
from numpy.typing import NDArray

Leaf = tuple[int, int, int, int, bool]
"""x, y, z of the least key, depth, occupied."""


def read_binary(body: bytes, depth: int = 0, corner: tuple[int, int, int] = (0, 0, 0)) -> tuple[list[Leaf], bytes]:
    """Return the leaves below an inner node, and the rest of the file after it."""
    word, rest = int.from_bytes(body[:2], "little"), body[2:]
    leaves: list[Leaf] = []
    for child in range(8):
        kind = word >> 2 * child & 3
        half = 1 << 15 - depth
        x, y, z = (least + half * (child >> axis & 1) for axis, least in enumerate(corner))
        if kind == 3:
            under, rest = read_binary(rest, depth + 1, (x, y, z))
            leaves += under
        elif kind:
            leaves.append((x, y, z, depth + 1, kind == 2))
    return leaves, rest


def write(data: NDArray[np.uint8], kind: str, extra: bytes = b"") -> tuple[bytes, int]:
    """Return the nodes of a grid that begins at key 32768 as ``bt`` or ``ot`` file, and their number."""
    body, count = _node(data, kind, extra, 0, (0, 0, 0))
    return body, count


def _state(data: NDArray[np.uint8], depth: int, corner: tuple[int, int, int]) -> int | None:
    """Return the common value of all voxels of a cube, or None if they differ."""
    edge = 1 << 16 - depth
    x, y, z = (least - 32768 for least in corner)
    if min(x, y, z) + edge <= 0:
        return 255
    layers, rows, columns = (slice(max(0, at), max(0, at + edge)) for at in (z, y, x))
    part = data[layers, rows, columns]
    values = set(np.unique(part).tolist()) | (set() if part.size == edge**3 else {255})
    return values.pop() if len(values) == 1 else None


def _node(
    data: NDArray[np.uint8], kind: str, extra: bytes, depth: int, corner: tuple[int, int, int]
) -> tuple[bytes, int]:
    half = 1 << 15 - depth
    below, nodes, word, mask = b"", 1, 0, 0
    for child in range(8):
        x, y, z = (least + half * (child >> axis & 1) for axis, least in enumerate(corner))
        state = _state(data, depth + 1, (x, y, z))
        if state == 255:
            continue
        mask |= 1 << child
        word |= (3 if state is None else 2 if state == 100 else 1) << 2 * child
        if state is None:
            text, count = _node(data, kind, extra, depth + 1, (x, y, z))
        else:
            text, count = struct.pack("<f", 3.5 if state == 100 else -2.0) + extra + b"\0", 1
            text = text if kind == "ot" else b""
        below += text
        nodes += count
    own = word.to_bytes(2, "little") if kind == "bt" else struct.pack("<f", 3.5) + extra + bytes([mask])
    return own + below, nodes
