"""Slow, obvious twins of the kernels over maps and costmaps."""

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D


def distance(occupied: NDArray[np.uint8], resolution: float) -> NDArray[np.float64]:
    """Return the distance to the nearest occupied cell [m]: the least over all of them."""
    height, width = occupied.shape
    cells = np.argwhere(occupied)
    result = np.full(occupied.shape, (height + width) * resolution)
    for row, column in np.ndindex(height, width):
        if len(cells):
            result[row, column] = resolution * np.hypot(*(cells - (row, column)).T).min()
    return result


def reachable(free: NDArray[np.bool_], row: int, column: int) -> NDArray[np.bool_]:
    """Return the cells that a breadth-first search finds over eight neighbours without cutting corners."""
    found = np.zeros(free.shape, np.bool_)
    queue = deque([(row, column)] if free[row, column] else [])
    while queue:
        r, c = queue.popleft()
        found[r, c] = True
        for dr, dc in [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0)]:
            near = (r + dr, c + dc)
            inside = 0 <= near[0] < free.shape[0] and 0 <= near[1] < free.shape[1]
            if not inside or found[near] or near in queue or not free[near]:
                continue
            if free[r, near[1]] and free[near[0], c]:
                queue.append(near)
    return found


def entered(ray: Pose2D, cell: tuple[int, int], grown: float) -> tuple[float, float]:
    """Return the ranges at which a ray enters and leaves a cell enlarged on all sides; enter > leave is a miss."""
    enter, leave = 0.0, math.inf
    row, column = cell
    for start, direction, side in ((ray.x, math.cos(ray.theta), column), (ray.y, math.sin(ray.theta), row)):
        low, high = side - grown, side + 1 + grown
        if abs(direction) < 1e-12:
            if not low <= start <= high:
                return math.inf, -math.inf
            continue
        ends = sorted(((low - start) / direction, (high - start) / direction))
        enter, leave = max(enter, ends[0]), min(leave, ends[1])
    return enter, leave


def cast(occupied: NDArray[np.uint8], ray: Pose2D, far: float, grown: float) -> float:
    """Return the range at which a ray first enters an occupied cell; all cells are tried, slightly enlarged."""
    hits = [math.inf]
    for row, column in np.argwhere(occupied).tolist():
        enter, leave = entered(ray, (row, column), grown)
        if enter <= leave and enter <= far + grown:
            hits.append(enter)
    return min(hits)


def stepped(occupied: NDArray[np.uint8], ray: Pose2D, far: float, step: float = 1e-3) -> float:
    """Return the range of the first of many fine steps that is in an occupied cell."""
    height, width = occupied.shape
    lengths = np.arange(0.0, far, step)
    columns = np.floor(ray.x + math.cos(ray.theta) * lengths).astype(int)
    rows = np.floor(ray.y + math.sin(ray.theta) * lengths).astype(int)
    inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
    hits = lengths[inside][occupied[rows[inside], columns[inside]] > 0]
    return float(hits[0]) if len(hits) else math.inf


def cost(distance: float, unknown: bool, inscribed: float, inflation: float, scaling: float) -> float:
    """Return the cost of a cell by costmap_2d's inflation layer, not yet rounded down."""
    if distance == 0.0:
        return 254
    if distance <= inscribed:
        return 253
    if unknown:
        return 255
    return 252 * math.exp(-scaling * (distance - inscribed)) if distance <= inflation else 0


def ended_in(shape: tuple[int, int], ray: Pose2D, reach: float) -> tuple[int, int] | None:
    """Return the cell 0.02 cells behind the end of a beam, if it is in the window."""
    if not 0.0 < reach < math.inf:
        return None
    column, row = (math.floor(v) for v in (ray @ Pose2D(reach + 0.02, 0.0))[:2])
    return (row, column) if 0 <= row < shape[0] and 0 <= column < shape[1] else None


def crossed(shape: tuple[int, int], ray: Pose2D, reach: float, raytrace: float, grown: float) -> NDArray[np.bool_]:
    """Return the cells, slightly enlarged, that a beam passes through, without the one in which it ends."""
    through = np.zeros(shape, np.bool_)
    if reach > 0.0:
        for cell in np.ndindex(*shape):
            enter, leave = entered(ray, cell, grown)
            through[cell] = enter <= leave and enter <= min(reach, raytrace) + grown
        end = ended_in(shape, ray, reach)
        if end is not None:
            through[end] = False
    return through
