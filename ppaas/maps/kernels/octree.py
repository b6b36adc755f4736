"""Kernels: walk through the nodes of OctoMap's files, write them, and fill voxel grids with their cubes.

The children of a node are numbered by their halves: bit 0 along x, bit 1 along y, bit 2 along z. Nodes lie in the order
of a walk that goes into the depth first. In a binary file (``.bt``) an inner node is two bytes, two bits a child, the
lowest first: 0 unknown, 1 free, 2 occupied, 3 an inner node. In a full one (``.ot``) each node is its log-odds
(float32, little-endian), what else its type has, and a byte with one bit a child.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]
Corners = NDArray[np.uint16]
Ints = NDArray[np.int64]

DEEPEST = 16

TRUNCATED = -1
"""The file ends within the tree."""
TOO_DEEP = -2
"""An inner node at the finest depth."""
CHILDLESS = -3
"""An inner node of a binary file without any child."""
TOO_MANY = -4
"""More nodes than there is room for."""
NOT_A_NUMBER = -5
"""A leaf whose log-odds are NaN."""


@njit(cache=True, nogil=True, error_model="numpy")
def read_binary(data: Bytes, corners: Corners, depths: Bytes, occupied: Bytes, counts: Ints) -> int:
    """Read the nodes of a binary file.

    Parameters
    ----------
    data : (m,) uint8 array
        The file after its header.
    corners : (n, 3) uint16 array
    depths, occupied : (n,) uint8 array
        Out: the leaves, as in `ppaas.maps.octree.OcTree`.
    counts : (2,) int64 array
        Out: nodes, and bytes used.

    Returns
    -------
    int
        How many leaves, or TRUNCATED, TOO_DEEP, CHILDLESS or TOO_MANY.
    """
    words = np.zeros(DEEPEST + 1, np.int64)
    path = np.zeros((DEEPEST + 1, 4), np.int64)  # x, y, z of the node at each depth, and its next child
    used, nodes, leaves, depth = 0, 0, 0, 0
    while depth >= 0:
        child = path[depth, 3]
        if child == 8:
            depth -= 1
            continue
        if child == 0:  # just come to: read it
            if used + 2 > data.size:
                return TRUNCATED
            words[depth] = data[used] | data[used + 1] << 8
            used += 2
            nodes += 1
            if words[depth] == 0:
                return CHILDLESS
        path[depth, 3] += 1
        kind = words[depth] >> (2 * child) & 3
        if kind == 0:
            continue
        half = 1 << (DEEPEST - 1 - depth)
        for axis in range(3):
            path[depth + 1, axis] = path[depth, axis] + (child >> axis & 1) * half
        if kind < 3:
            if leaves == len(corners):
                return TOO_MANY
            for axis in range(3):
                corners[leaves, axis] = path[depth + 1, axis]
            depths[leaves], occupied[leaves] = depth + 1, kind - 1
            leaves += 1
            continue
        if depth + 1 == DEEPEST:
            return TOO_DEEP
        depth += 1
        path[depth, 3] = 0
    counts[0], counts[1] = nodes + leaves, used
    return leaves


@njit(cache=True, nogil=True, error_model="numpy")
def read_full(data: Bytes, extra: int, corners: Corners, depths: Bytes, occupied: Bytes, counts: Ints) -> int:
    """Read the nodes of a full file; of a leaf without sign the log-odds are not below 0: occupied.

    Parameters
    ----------
    extra : int
        Bytes that each node has besides its log-odds and its children.
    data, corners, depths, occupied, counts
        As in ``read_binary``.

    Returns
    -------
    int
        How many leaves, or TRUNCATED, TOO_DEEP, TOO_MANY or NOT_A_NUMBER.
    """
    masks = np.zeros(DEEPEST + 1, np.int64)
    path = np.zeros((DEEPEST + 1, 4), np.int64)
    used, nodes, leaves, depth = 0, 0, 0, 0
    while depth >= 0:
        if path[depth, 3] == 0:  # just come to: read it
            if used + 5 + extra > data.size:
                return TRUNCATED
            high = np.int64(data[used + 3])
            bits = high << 24 | np.int64(data[used + 2]) << 16 | np.int64(data[used + 1]) << 8 | np.int64(data[used])
            masks[depth] = data[used + 4 + extra]
            used += 5 + extra
            nodes += 1
            if bits & 0x7FFFFFFF > 0x7F800000:
                return NOT_A_NUMBER
            if masks[depth] == 0:
                if leaves == len(corners):
                    return TOO_MANY
                for axis in range(3):
                    corners[leaves, axis] = path[depth, axis]
                depths[leaves], occupied[leaves] = depth, bits <= 0x80000000
                leaves += 1
            elif depth == DEEPEST:
                return TOO_DEEP
        child = path[depth, 3]
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


@njit(cache=True, nogil=True, error_model="numpy")
def write_binary(corners: Corners, depths: Bytes, occupied: Bytes, shared: Ints, data: Bytes) -> int:
    """Write the nodes of a binary file and return how many bytes they took.

    Parameters
    ----------
    corners, depths, occupied
        As in ``read_binary``; no leaf is the root.
    shared : (n,) int64 array
        Depth of the node that is above both a leaf and the one before; 0 for the first.
    data : (m,) uint8 array
        Out: zeros to begin with, two bytes for each inner node.
    """
    places = np.zeros(DEEPEST + 1, np.int64)
    used = 2
    for leaf in range(len(corners)):
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


@njit(cache=True, nogil=True, error_model="numpy")
def fill_cubes(voxels: NDArray[np.uint8], corners: Ints, edges: Ints, values: Bytes) -> None:
    """Write values into cubes, as far as they lie in a grid.

    Parameters
    ----------
    voxels : (depth, height, width) uint8 array
        Out.
    corners : (n, 3) int64 array
        First column, row and layer of each cube.
    edges : (n,) int64 array
    values : (n,) uint8 array
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
    one = np.ones(1, np.int64)
    fill_cubes(np.zeros((1, 1, 1), np.uint8), np.zeros((1, 3), np.int64), one, occupied[:1])
