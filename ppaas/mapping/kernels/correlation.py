"""Kernels: grid of the likelihood of points near key frames, and exhaustive search of a scan on it (Olson, 2009)."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled

HIGHEST = np.uint8(255)
"""Likelihood of a cell with a point."""

ALIKE, THIN = 0.9, 0.05
"""Least cosine between the normals of two points on one line, and the largest distance of each from it [m]."""

PENALTY = 0.05
"""Part of the score that is subtracted at the edge of the window, so that equal scores stay near the start."""


@compiled
def _stamp(grid: NDArray[np.uint8], column: int, row: int, blur: NDArray[np.uint8]) -> None:
    """Blend the likelihood around a point into the cells around (row, column), by maximum; not at the edges."""
    half = blur.shape[0] // 2
    if not (half <= row < grid.shape[0] - half and half <= column < grid.shape[1] - half):
        return
    if grid[row, column] == HIGHEST:  # another point was drawn there
        return
    for v in range(2 * half + 1):
        for u in range(2 * half + 1):
            cell = row - half + v, column - half + u
            grid[cell] = max(grid[cell], blur[v, u])


@compiled
def _joins(points: NDArray[np.float32], normals: NDArray[np.float32], before: int, beam: int) -> bool:
    """Return whether the points of two successive beams lie on one line: both normals are those of the other, too."""
    dx, dy = points[beam, 0] - points[before, 0], points[beam, 1] - points[before, 1]
    facing = normals[before, 0] * normals[beam, 0] + normals[before, 1] * normals[beam, 1]
    off = max(
        abs(normals[before, 0] * dx + normals[before, 1] * dy), abs(normals[beam, 0] * dx + normals[beam, 1] * dy)
    )
    return bool(facing > ALIKE) and bool(off < THIN)


@compiled
def draw(
    grid: NDArray[np.uint8],
    x0: float,
    y0: float,
    resolution: float,
    blur: NDArray[np.uint8],
    near: NDArray[np.int64],
    poses: NDArray[np.float64],
    points: NDArray[np.float32],
    normals: NDArray[np.float32],
    valid: NDArray[np.bool_],
) -> None:
    """Draw the surfaces seen by key frames: each cell gets the highest likelihood of a point or line near it.

    Points of successive beams on one line are joined. Single points would lie denser close to the laser, and along a
    corridor the highest score would be that of the pose from which the corridor was seen before.

    Parameters
    ----------
    grid : (height, width) uint8 array
        Modified: cleared, then drawn.
    x0, y0 : float
        Corner of cell (0, 0) in the map frame [m].
    resolution : float
        Edge of a cell [m].
    blur : (2h + 1, 2h + 1) uint8 array
        Likelihood of the cells around a point, `HIGHEST` in the middle.
    near : (m,) int64 array
        Indices of the key frames.
    poses : (m, 3) float64 array
        Their poses in the map frame: x, y [m], theta [rad].
    points, normals : (k, b, 2) float32 array
        Points [m] and normals of all key frames, each in its own frame; (0, 0) = no normal.
    valid : (k, b) bool array
        Whether each point is one.
    """
    grid[:, :] = 0
    for m in range(near.size):
        c, s = math.cos(poses[m, 2]) / resolution, math.sin(poses[m, 2]) / resolution
        x1, y1 = (poses[m, 0] - x0) / resolution, (poses[m, 1] - y0) / resolution
        scan, facing, is_point = points[near[m]], normals[near[m]], valid[near[m]]
        last_x, last_y = 0.0, 0.0
        for b in range(scan.shape[0]):
            if not is_point[b]:
                continue
            x, y = c * scan[b, 0] - s * scan[b, 1] + x1, s * scan[b, 0] + c * scan[b, 1] + y1
            _stamp(grid, math.floor(x), math.floor(y), blur)
            if b > 0 and is_point[b - 1] and _joins(scan, facing, b - 1, b):
                # A point per cell between the two.
                count = int(max(abs(x - last_x), abs(y - last_y)))
                for k in range(1, count + 1):
                    part = k / (count + 1.0)
                    _stamp(
                        grid, math.floor(last_x + part * (x - last_x)), math.floor(last_y + part * (y - last_y)), blur
                    )
            last_x, last_y = x, y


@compiled
def search(
    grid: NDArray[np.uint8],
    x0: float,
    y0: float,
    resolution: float,
    points: NDArray[np.float32],
    valid: NDArray[np.bool_],
    stride: int,
    start: NDArray[np.float64],
    cells: int,
    turns: int,
    turn: float,
) -> tuple[NDArray[np.float64], float]:
    """Return the pose of a scan with the highest mean likelihood in a window around a start, and that mean.

    Parameters
    ----------
    grid, x0, y0, resolution
        See `draw`.
    points, valid
        Scan, in the frame of the laser.
    stride : int
        Distance between the beams used [beams].
    start : (3,) float64 array
        Middle of the window in the map frame: x, y [m], theta [rad].
    cells, turns : int
        Steps of the window to each side, over positions and headings.
    turn : float
        Step of the heading [rad]; that of the position is a cell.

    Returns
    -------
    pose : (3,) float64 array
    score : float
        From 0 to 1, without the penalty of `PENALTY`.
    """
    height, width = grid.shape
    rows, columns = np.empty(points.shape[0], np.int64), np.empty(points.shape[0], np.int64)
    best, score, used = -1.0, 0.0, 0
    best_u, best_v, best_a = 0, 0, 0
    for a in range(-turns, turns + 1):
        # Cells of the points at this heading.
        heading = start[2] + a * turn
        c, s = math.cos(heading) / resolution, math.sin(heading) / resolution
        x, y = (start[0] - x0) / resolution, (start[1] - y0) / resolution
        used = 0
        for b in range(0, points.shape[0], stride):
            if valid[b]:
                columns[used] = math.floor(c * points[b, 0] - s * points[b, 1] + x)
                rows[used] = math.floor(s * points[b, 0] + c * points[b, 1] + y)
                used += 1
        # Sums over all shifts of whole cells.
        for v in range(-cells, cells + 1):
            for u in range(-cells, cells + 1):
                total = 0
                for i in range(used):
                    row, column = rows[i] + v, columns[i] + u
                    if 0 <= row < height and 0 <= column < width:
                        total += grid[row, column]
                away = (u * u + v * v) / (cells * cells + 1.0) + a * a / (turns * turns + 1.0)
                rated = total * (1.0 - PENALTY * away)
                if rated > best:
                    best, score, best_u, best_v, best_a = rated, float(total), u, v, a
    pose = start.copy()
    pose[0] += best_u * resolution
    pose[1] += best_v * resolution
    pose[2] += best_a * turn
    return pose, score / (max(used, 1) * 255.0)


def warm() -> None:
    """Call the kernels once, so that they are compiled or loaded from the cache."""
    grid, points, valid = np.zeros((1, 1), np.uint8), np.zeros((1, 1, 2), np.float32), np.ones((1, 1), np.bool_)
    draw(grid, 0.0, 0.0, 1.0, grid, np.zeros(1, np.int64), np.zeros((1, 3)), points, points, valid)
    search(grid, 0.0, 0.0, 1.0, points[0], valid[0], 1, np.zeros(3), 0, 0, 0.1)
