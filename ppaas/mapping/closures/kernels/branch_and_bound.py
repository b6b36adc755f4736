"""Kernel: the best rigid motion of points onto a likelihood pyramid, by branch and bound.

As in Hess et al., *Real-Time Loop Closure in 2D LIDAR SLAM* (ICRA 2016), algorithm 3: a node is a rotation with a
square of translations, the pyramid bounds its score, and the search descends depth first into the best nodes.
"""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.mapping.closures.kernels.pyramid import FULL_LEVELS, PADDING, block_shift, build_levels


@compiled
def _rotated_cells(
    points: NDArray[np.float64], turn: float, x0: float, y0: float, resolution: float, first: NDArray[np.int64]
) -> NDArray[np.int32]:
    """Return the cells of points after a rotation about the origin and the first translation of the window.

    Parameters
    ----------
    points : (n, 2) array
        Points [m].
    turn : float
        Rotation [rad].
    x0, y0 : float
        Lower-left corner of cell (0, 0) [m].
    resolution : float
        Edge of a cell [m].
    first : (2,) int64 array
        First translation, in x and y [cells].

    Returns
    -------
    (2, n) int32 array
        Columns and rows.
    """
    cells = np.empty((2, points.shape[0]), np.int32)
    c, s = math.cos(turn), math.sin(turn)
    for i in range(points.shape[0]):
        x, y = c * points[i, 0] - s * points[i, 1], s * points[i, 0] + c * points[i, 1]
        cells[0, i] = math.floor((x - x0) / resolution) + first[0]
        cells[1, i] = math.floor((y - y0) / resolution) + first[1]
    return cells


@compiled
def _group(cells: NDArray[np.int32], shift: int, out: NDArray[np.int32]) -> int:
    """Write the blocks that contain points, each with its number of points, and return the number of blocks.

    Parameters
    ----------
    cells : (2, n) int32 array
        Columns and rows of the points.
    shift : int
        Binary logarithm of the edge of a block [cells].
    out : (3, n) int32 array
        Column and row of each block, and its number of points.
    """
    u0, v0 = cells[0].min() >> shift, cells[1].min() >> shift
    width, height = (cells[0].max() >> shift) - u0 + 1, (cells[1].max() >> shift) - v0 + 1
    index = np.full(width * height, -1, np.int32)
    m = 0
    for i in range(cells.shape[1]):
        u, v = cells[0, i] >> shift, cells[1, i] >> shift
        at = (v - v0) * width + u - u0
        if index[at] < 0:
            index[at] = m
            out[0, m], out[1, m], out[2, m] = u, v, 0
            m += 1
        out[2, index[at]] += 1
    return m


@compiled
def _sum(
    values: NDArray[np.uint8], size: NDArray[np.int64], blocks: NDArray[np.int32], count: int, du: int, dv: int
) -> int:
    """Return the sum of a level's values over blocks, moved by a translation.

    Parameters
    ----------
    values : (n,) uint8 array
        Values of the pyramid.
    size : (3,) int64 array
        First value, height and width of the level.
    blocks : (3, m) int32 array
        Column and row of each block, and its number of points.
    count : int
        Number of blocks.
    du, dv : int
        Translation [blocks].
    """
    start, height, width = size[0], np.uint64(size[1]), np.uint64(size[2])
    du += PADDING
    dv += PADDING
    total = 0
    for i in range(count):
        # Negative indices are huge as unsigned ones, so that one comparison checks both ends.
        u, v = np.uint64(np.int64(blocks[0, i]) + du), np.uint64(np.int64(blocks[1, i]) + dv)
        if u < width and v < height:
            total += blocks[2, i] * np.int64(values[np.uint64(start) + v * width + u])
    return total


@compiled
def _all_excluded(
    u: int, v: int, edge: int, turned: float, excluded: NDArray[np.float64], last: NDArray[np.int64]
) -> bool:
    """Return whether all translations of a node are in the excluded disc.

    Parameters
    ----------
    u, v, edge : int
        First translation of the node from the window's first, and the edge of its square [cells].
    turned : float
        Difference of its rotation from that of the excluded disc [rad].
    excluded : (5,) array
        As in `best_motion`.
    last : (2,) int64 array
        Last translation of the window from its first [cells].
    """
    if excluded[2] <= 0.0 or abs(turned) > excluded[3]:
        return False
    u1, v1 = min(u + edge - 1, last[0]), min(v + edge - 1, last[1])
    du = max(abs(u - excluded[0]), abs(u1 - excluded[0]))
    dv = max(abs(v - excluded[1]), abs(v1 - excluded[1]))
    return bool(du * du + dv * dv < excluded[2] * excluded[2])


@compiled
def best_motion(
    values: NDArray[np.uint8],
    sizes: NDArray[np.int64],
    corner: NDArray[np.float64],
    resolution: float,
    points: NDArray[np.float64],
    turns: NDArray[np.float64],
    half: NDArray[np.int64],
    least: int,
    excluded: NDArray[np.float64],
) -> tuple[int, int, int, int]:
    """Return the motion with the largest sum of grid values under the points.

    Parameters
    ----------
    values : (n,) uint8 array
        Values of the pyramid, level after level.
    sizes : (levels, 3) int64 array
        First value, height and width of each level.
    corner : (2,) array
        Lower-left corner of cell (0, 0) [m].
    resolution : float
        Edge of a cell [m].
    points : (p, 2) array
        Points, in a frame whose origin they are rotated about [m].
    turns : (t,) array
        Rotations that are tried [rad].
    half : (2,) int64 array
        Largest translation along x and along y, in both directions [cells].
    least : int
        The sum has to be larger than this.
    excluded : (5,) array
        Motions left out: a disc of translations, its centre in x and y counted from −``half``, and its radius [cells];
        the largest difference of rotation from the disc's, and the rotation of the disc [rad]. A radius of 0 excludes
        nothing.

    Returns
    -------
    (turn, du, dv, sum)
        Index of the rotation, translation [cells], sum of the values; the index is −1 if no sum is large enough.
    """
    top, p = sizes.shape[0] - 1, points.shape[0]
    # Cells of the points by rotation, and their blocks by rotation and level (filled when a node needs them).
    blocks = np.empty((turns.size, max(sizes.shape[0] - FULL_LEVELS, 0) + 1, 3, p), np.int32)
    counts = np.zeros((turns.size, blocks.shape[1]), np.int64)
    last = 2 * half
    # Phase 1: bounds of all nodes of the highest level.
    edge, shift = 1 << top, block_shift(top)
    columns, rows = last[0] // edge + 1, last[1] // edge + 1
    nodes = np.empty((turns.size * columns * rows, 3), np.int64)
    bounds = np.empty(nodes.shape[0], np.int64)
    n = 0
    for a in range(turns.size):
        blocks[a, 0, :2] = _rotated_cells(points, turns[a], corner[0], corner[1], resolution, -half)
        blocks[a, 0, 2] = 1
        counts[a, 0] = p
        if shift > 0:
            counts[a, shift] = _group(blocks[a, 0, :2], shift, blocks[a, shift])
        for v in range(0, last[1] + 1, edge):
            for u in range(0, last[0] + 1, edge):
                bound = _sum(values, sizes[top], blocks[a, shift], counts[a, shift], u >> shift, v >> shift)
                if bound > least:
                    nodes[n, 0], nodes[n, 1], nodes[n, 2] = a, u, v
                    bounds[n] = bound
                    n += 1
    # Phase 2: descend depth first, the best node first, and leave out nodes that cannot beat the best leaf.
    best, best_a, best_u, best_v = least, -1, 0, 0
    stack = np.empty((3 * top + 4, 5), np.int64)
    for at in np.argsort(-bounds[:n]):
        if bounds[at] <= best:
            break
        stack[0, 0], stack[0, 1], stack[0, 2], stack[0, 3] = nodes[at, 0], nodes[at, 1], nodes[at, 2], top
        stack[0, 4] = bounds[at]
        depth = 1
        while depth > 0:
            depth -= 1
            a, u, v, level, bound = stack[depth]
            if bound <= best:
                continue
            if _all_excluded(u, v, 1 << level, turns[a] - excluded[4], excluded, last):
                continue
            if level == 0:
                best, best_a, best_u, best_v = bound, a, u, v
                continue
            edge, shift = 1 << (level - 1), block_shift(level - 1)
            if counts[a, shift] == 0:
                counts[a, shift] = _group(blocks[a, 0, :2], shift, blocks[a, shift])
            floor = depth
            for child in range(4):
                cu, cv = u + (child & 1) * edge, v + (child >> 1) * edge
                if cu > last[0] or cv > last[1]:
                    continue
                bound = _sum(values, sizes[level - 1], blocks[a, shift], counts[a, shift], cu >> shift, cv >> shift)
                if bound <= best:
                    continue
                # Insert by bound, so that the best child is on top of the stack.
                i = depth
                while i > floor and stack[i - 1, 4] > bound:
                    stack[i] = stack[i - 1]
                    i -= 1
                stack[i, 0], stack[i, 1], stack[i, 2], stack[i, 3], stack[i, 4] = a, cu, cv, level - 1, bound
                depth += 1
    return best_a, best_u - half[0], best_v - half[1], best


def warm() -> None:
    """Call the kernel once, so that it is compiled or loaded from the cache."""
    values, sizes = build_levels(np.ones((4, 4), np.uint8), FULL_LEVELS + 1)
    corner, half = np.zeros(2), np.ones(2, np.int64)
    best_motion(values, sizes, corner, 0.1, np.zeros((1, 2)), np.zeros(1), half, 0, np.zeros(5))
