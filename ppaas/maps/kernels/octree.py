"""Kernels: reading and writing of the nodes of OctoMap files, and filling of voxel grids with their cubes.

The number of a child has one bit per axis (bit 0 for x, 1 for y, 2 for z), which is set for the upper half. Nodes are
in depth-first order. In a binary file (``.bt``) an inner node takes two bytes with two bits per child, the lowest bits
first: 0 unknown, 1 free, 2 occupied, 3 inner node. In a full file (``.ot``) each node consists of its log-odds
(float32, little-endian), the extra bytes of its type, and a byte with one bit per child.

All readers traverse the tree with an explicit stack, ``path``: for each depth the least key (x, y, z) of the current
node and the number of its next child.
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled

Bytes = NDArray[np.uint8]
Corners = NDArray[np.uint16]
Ints = NDArray[np.int64]
Floats = NDArray[np.float32]

DEEPEST = 16
"""Depth of the finest voxels."""

TRUNCATED = -1
"""The file ends within the tree."""
TOO_DEEP = -2
"""An inner node at the finest depth."""
CHILDLESS = -3
"""An inner node of a binary file has no child."""
TOO_MANY = -4
"""The tree has more leaves than the output arrays."""
NOT_A_NUMBER = -5
"""The log-odds of a node are NaN."""


@compiled
def read_binary(data: Bytes, corners: Corners, depths: Bytes, occupied: Bytes, counts: Ints) -> int:
    """Read the nodes of a binary file.

    Parameters
    ----------
    data : (m,) uint8 array
        Content of the file after its header.
    corners : (n, 3) uint16 array
        Out: least key of each leaf along x, y and z.
    depths : (n,) uint8 array
        Out: depth of each leaf.
    occupied : (n,) uint8 array
        Out: 1 for an occupied leaf, 0 for a free one.
    counts : (2,) int64 array
        Out: number of nodes, and of bytes read.

    Returns
    -------
    int
        Number of leaves, or TRUNCATED, TOO_DEEP, CHILDLESS or TOO_MANY.
    """
    words = np.zeros(DEEPEST + 1, np.int64)  # the 16 bits of the current node at each depth
    path = np.zeros((DEEPEST + 1, 4), np.int64)  # x, y, z of the current node at each depth, and its next child
    used, nodes, leaves, depth = 0, 0, 0, 0
    while depth >= 0:
        child = path[depth, 3]
        if child == 8:  # all children are done: return to the parent
            depth -= 1
            continue
        if child == 0:  # first visit of the node: read it
            if used + 2 > data.size:
                return TRUNCATED
            words[depth] = data[used] | data[used + 1] << 8
            used += 2
            nodes += 1
            if words[depth] == 0:
                return CHILDLESS
        path[depth, 3] += 1
        kind = words[depth] >> (2 * child) & 3
        if kind == 0:  # unknown
            continue
        half = 1 << (DEEPEST - 1 - depth)
        for axis in range(3):
            path[depth + 1, axis] = path[depth, axis] + (child >> axis & 1) * half
        if kind < 3:  # a leaf
            if leaves == len(corners):
                return TOO_MANY
            for axis in range(3):
                corners[leaves, axis] = path[depth + 1, axis]
            depths[leaves], occupied[leaves] = depth + 1, kind - 1
            leaves += 1
            continue
        if depth + 1 == DEEPEST:
            return TOO_DEEP
        depth += 1  # an inner node: descend to it
        path[depth, 3] = 0
    counts[0], counts[1] = nodes + leaves, used
    return leaves


@compiled
def read_full(data: Bytes, extra: int, corners: Corners, depths: Bytes, occupied: Bytes, counts: Ints) -> int:
    """Read the nodes of a full file. A leaf is occupied if its log-odds are at least 0.

    Parameters
    ----------
    extra : int
        Number of bytes of each node besides its log-odds and its children.
    data, corners, depths, occupied, counts
        As in ``read_binary``.

    Returns
    -------
    int
        Number of leaves, or TRUNCATED, TOO_DEEP, TOO_MANY or NOT_A_NUMBER.
    """
    masks = np.zeros(DEEPEST + 1, np.int64)  # children of the current node at each depth, one bit each
    path = np.zeros((DEEPEST + 1, 4), np.int64)  # x, y, z of the current node at each depth, and its next child
    used, nodes, leaves, depth = 0, 0, 0, 0
    while depth >= 0:
        if path[depth, 3] == 0:  # first visit of the node: read it
            if used + 5 + extra > data.size:
                return TRUNCATED
            high = np.int64(data[used + 3])
            bits = high << 24 | np.int64(data[used + 2]) << 16 | np.int64(data[used + 1]) << 8 | np.int64(data[used])
            masks[depth] = data[used + 4 + extra]
            used += 5 + extra
            nodes += 1
            if bits & 0x7FFFFFFF > 0x7F800000:
                return NOT_A_NUMBER
            if masks[depth] == 0:  # a leaf; its float32 is at least 0 (or −0.0) if its bits are at most 0x80000000
                if leaves == len(corners):
                    return TOO_MANY
                for axis in range(3):
                    corners[leaves, axis] = path[depth, axis]
                depths[leaves], occupied[leaves] = depth, bits <= 0x80000000
                leaves += 1
            elif depth == DEEPEST:
                return TOO_DEEP
        child = path[depth, 3]  # descend to the next child that exists, or return to the parent
        while child < 8 and not masks[depth] >> child & 1:
            child += 1
        path[depth, 3] = child + 1
        if child >= 8:
            depth -= 1
            continue
        half = 1 << (DEEPEST - 1 - depth)
        for axis in range(3):
            path[depth + 1, axis] = path[depth, axis] + (child >> axis & 1) * half
        depth += 1
        path[depth, 3] = 0
    counts[0], counts[1] = nodes, used
    return leaves


@compiled
def write_binary(corners: Corners, depths: Bytes, occupied: Bytes, shared: Ints, data: Bytes) -> int:
    """Write the nodes of a binary file; return the number of bytes.

    Parameters
    ----------
    corners, depths, occupied
        Leaves in depth-first order, as in ``read_binary``; none of them is the root.
    shared : (n,) int64 array
        Depth of the lowest common ancestor of each leaf and the leaf before it; 0 for the first leaf.
    data : (m,) uint8 array
        In: zeros, two bytes for each inner node. Out: the nodes.
    """
    places = np.zeros(DEEPEST + 1, np.int64)  # position in ``data`` of the current inner node at each depth
    used = 2
    for leaf in range(len(corners)):
        # Append the inner nodes between the common ancestor and the leaf, and mark each node in its parent's word.
        for depth in range(shared[leaf] + 1, depths[leaf] + 1):
            kind = occupied[leaf] + 1 if depth == depths[leaf] else 3
            bit = DEEPEST - depth
            child = 0
            for axis in range(3):
                child |= (corners[leaf, axis] >> bit & 1) << axis
            data[places[depth - 1] + (child >> 2)] |= kind << (2 * (child & 3))
            if kind == 3:
                places[depth] = used
                used += 2
    return used


@compiled
def number_nodes(
    corners: Corners, depths: Bytes, log_odds: Floats, shared: Ints, values: Floats, children: Bytes
) -> None:
    """Find the nodes of a full file in depth-first order. The log-odds of an inner node are the greatest below it.

    Parameters
    ----------
    corners, depths, shared
        Leaves in depth-first order, as in ``write_binary``.
    log_odds : (n,) float32 array
        Log-odds of the leaves.
    values : (m,) float32 array
        Out: log-odds of all nodes.
    children : (m,) uint8 array
        In: zeros. Out: children of all nodes, one bit each.
    """
    places = np.zeros(DEEPEST + 1, np.int64)  # number of the current node at each depth
    used = 1
    values[0] = -np.inf
    for leaf in range(len(corners)):
        for depth in range(shared[leaf] + 1, depths[leaf] + 1):  # nodes below the common ancestor
            bit = DEEPEST - depth
            child = 0
            for axis in range(3):
                child |= (corners[leaf, axis] >> bit & 1) << axis
            children[places[depth - 1]] |= 1 << child
            places[depth] = used
            values[used] = -np.inf
            used += 1
        for depth in range(depths[leaf] + 1):
            values[places[depth]] = max(values[places[depth]], log_odds[leaf])


@compiled
def fill_cubes(voxels: NDArray[np.uint8], corners: Ints, edges: Ints, values: Bytes) -> None:
    """Fill cubes with values, clipped to the grid.

    Parameters
    ----------
    voxels : (depth, height, width) uint8 array
        Out: the grid.
    corners : (n, 3) int64 array
        First column, row and layer of each cube; may be outside the grid.
    edges : (n,) int64 array
        Edge of each cube [voxels].
    values : (n,) uint8 array
        Value of each cube.
    """
    depth, height, width = voxels.shape
    for cube in range(len(corners)):
        x, y, z = corners[cube]
        edge = edges[cube]
        for layer in range(max(z, 0), min(z + edge, depth)):
            for row in range(max(y, 0), min(y + edge, height)):
                for column in range(max(x, 0), min(x + edge, width)):
                    voxels[layer, row, column] = values[cube]


def warm() -> None:
    """Compile and call each kernel once."""
    corners, depths, occupied = np.zeros((8, 3), np.uint16), np.zeros(8, np.uint8), np.zeros(8, np.uint8)
    counts = np.zeros(2, np.int64)
    data = np.array([2, 0], np.uint8)
    data.flags.writeable = False
    leaves = read_binary(data, corners, depths, occupied, counts)
    read_full(np.frombuffer(bytes(5), np.uint8), 0, corners, depths, occupied, counts)
    shared = np.zeros(leaves, np.int64)
    write_binary(corners[:leaves], depths[:leaves], occupied[:leaves], shared, np.zeros(2, np.uint8))
    values = np.zeros(9, np.float32)
    number_nodes(corners[:leaves], depths[:leaves], values[:leaves], shared, values, np.zeros(9, np.uint8))
    one = np.ones(1, np.int64)
    fill_cubes(np.zeros((1, 1, 1), np.uint8), np.zeros((1, 3), np.int64), one, occupied[:1])
