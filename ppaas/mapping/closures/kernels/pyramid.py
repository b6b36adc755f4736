"""Kernels: a blurred grid of points, and its pyramid of maxima.

Level h of the pyramid bounds the score of a point at 2^h by 2^h neighbouring translations at once. From level 3 on, one
entry also bounds all points of a block of 2^(h − 2) cells, as in Olson, *M3RSM: Many-to-Many Multi-Resolution Scan
Matching* (ICRA 2015), so that the search adds blocks instead of points and the upper levels stay in the cache.
"""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled

PADDING = 4
"""Blocks before the first one of a level: a window that starts outside the grid may still reach into it."""

FULL_LEVELS = 3
"""Levels whose blocks are single cells."""


@compiled
def block_shift(level: int) -> int:
    """Return the binary logarithm of the edge of a level's blocks [cells]."""
    return max(level - FULL_LEVELS + 1, 0)


@compiled
def blurred_grid(
    points: NDArray[np.float64],
    x0: float,
    y0: float,
    resolution: float,
    height: int,
    width: int,
    blur: NDArray[np.uint8],
) -> NDArray[np.uint8]:
    """Return a grid in which each cell holds the largest blur value of the points around it.

    Parameters
    ----------
    points : (n, 2) array
        Points [m].
    x0, y0 : float
        Lower-left corner of cell (0, 0) [m].
    resolution : float
        Edge of a cell [m].
    height, width : int
        Size of the grid [cells].
    blur : (2 r + 1, 2 r + 1) uint8 array
        Value around a point by offset in cells.
    """
    occupied = np.zeros((height, width), np.bool_)
    grid = np.zeros((height, width), np.uint8)
    r = blur.shape[0] // 2
    for i in range(points.shape[0]):
        u, v = math.floor((points[i, 0] - x0) / resolution), math.floor((points[i, 1] - y0) / resolution)
        if u < 0 or v < 0 or u >= width or v >= height or occupied[v, u]:
            continue
        occupied[v, u] = True
        for dv in range(max(-r, -v), min(r + 1, height - v)):
            for du in range(max(-r, -u), min(r + 1, width - u)):
                grid[v + dv, u + du] = max(grid[v + dv, u + du], blur[dv + r, du + r])
    return grid


@compiled
def _halved(blocks: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the maxima of blocks of 2 by 2 entries."""
    height, width = blocks.shape
    out = np.zeros(((height + 1) // 2, (width + 1) // 2), np.uint8)
    for v in range(height):
        for u in range(width):
            out[v >> 1, u >> 1] = max(out[v >> 1, u >> 1], blocks[v, u])
    return out


@compiled
def _window_maxima(blocks: NDArray[np.uint8], window: int) -> NDArray[np.uint8]:
    """Return maxima over windows of entries.

    Parameters
    ----------
    blocks : (height, width) uint8 array
        Entries; those outside count as 0.
    window : int
        Edge of a window [entries].

    Returns
    -------
    (height + PADDING, width + PADDING) uint8 array
        Entry (v + PADDING, u + PADDING) is the maximum over rows v … v + window − 1, columns u … u + window − 1.
    """
    height, width = blocks.shape
    padded = np.zeros((height + 2 * PADDING, width + 2 * PADDING), np.uint8)
    padded[PADDING : PADDING + height, PADDING : PADDING + width] = blocks
    # The maximum is separable: first along rows, then along columns.
    rows = padded[:, : width + PADDING].copy()
    for k in range(1, window):
        for v in range(rows.shape[0]):
            for u in range(rows.shape[1]):
                rows[v, u] = max(rows[v, u], padded[v, u + k])
    out = rows[: height + PADDING].copy()
    for k in range(1, window):
        for v in range(out.shape[0]):
            for u in range(out.shape[1]):
                out[v, u] = max(out[v, u], rows[v + k, u])
    return out


@compiled
def build_levels(grid: NDArray[np.uint8], levels: int) -> tuple[NDArray[np.uint8], NDArray[np.int64]]:
    """Return the pyramid of a grid.

    Parameters
    ----------
    grid : (height, width) uint8 array
        Blurred grid.
    levels : int
        Number of levels; a window of the highest has an edge of 2^(levels − 1) cells.

    Returns
    -------
    (n,) uint8 array
        Values of all levels, one after the other, each row by row.
    (levels, 3) int64 array
        First value, height and width of each level, with `PADDING` rows and columns before the first block.
    """
    sizes = np.zeros((levels, 3), np.int64)
    height, width = grid.shape
    total = 0
    for level in range(levels):
        edge = 1 << block_shift(level)
        sizes[level, 0] = total
        sizes[level, 1] = (height + edge - 1) // edge + PADDING
        sizes[level, 2] = (width + edge - 1) // edge + PADDING
        total += sizes[level, 1] * sizes[level, 2]
    values = np.empty(total, np.uint8)
    blocks = grid
    for level in range(levels):
        if block_shift(level) > 0:
            blocks = _halved(blocks)
        # Window of 2^h translations, and from level 3 on of the cells of a block besides: 4 blocks + 1.
        window = 1 << level if level < FULL_LEVELS else PADDING + 1
        found = _window_maxima(blocks, window)
        values[sizes[level, 0] : sizes[level, 0] + found.size] = found.ravel()
    return values, sizes


def warm() -> None:
    """Call the kernels once, so that they are compiled or loaded from the cache."""
    blur = np.full((1, 1), 255, np.uint8)
    blur.flags.writeable = False
    build_levels(blurred_grid(np.zeros((1, 2)), 0.0, 0.0, 0.1, 1, 1, blur), 1)
