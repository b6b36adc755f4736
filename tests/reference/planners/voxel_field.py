"""Slow, obvious twins of the cost field in space: its definition, with a heap."""

import heapq
import itertools
import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tests.reference.planners.dijkstra import weight

Voxel = tuple[int, int, int]

MOVES = [move for move in itertools.product((-1, 0, 1), repeat=3) if any(move)]


def steps_from(costs: NDArray[np.uint8], voxel: Voxel, allow_unknown: bool) -> Iterator[tuple[Voxel, int]]:
    """Yield each neighbour that may be entered, and the number of axes of the move; its whole cube must be free."""
    for move in MOVES:
        cube = list(itertools.product(*({at, at + step} for at, step in zip(voxel, move, strict=True))))
        inside = all(0 <= index < size for corner in cube for index, size in zip(corner, costs.shape, strict=True))
        if inside and all(
            math.isfinite(weight(int(costs[corner]), allow_unknown)) for corner in cube if corner != voxel
        ):
            yield tuple(at + step for at, step in zip(voxel, move, strict=True)), sum(map(abs, move))


def cost_field(
    costs: NDArray[np.uint8], goals: list[Voxel], allow_unknown: bool = True, *, units: int | None = None
) -> NDArray[np.float64]:
    """Return the cost-to-go of each voxel; with ``units``, in fixed point with that scale, each move rounded."""
    field = np.full(costs.shape, math.inf)
    queue = [(0.0, goal) for goal in goals]
    for goal in goals:
        field[goal] = 0.0
    while queue:
        value, voxel = heapq.heappop(queue)
        if value > field[voxel]:
            continue
        for neighbour, axes in steps_from(costs, voxel, allow_unknown):
            step = weight(int(costs[neighbour]), allow_unknown)
            step = step * math.sqrt(axes) if units is None else float(round(round(step * units) * math.sqrt(axes)))
            if value + step < field[neighbour]:
                field[neighbour] = value + step
                heapq.heappush(queue, (value + step, neighbour))
    return field


def edges(costs: NDArray[np.uint8], allow_unknown: bool = True) -> list[tuple[int, int, float]]:
    """Return all moves as (from, to, weight) for a graph library; voxels are flat indices."""
    found = []
    for voxel in np.ndindex(costs.shape):
        if math.isfinite(weight(int(costs[voxel]), allow_unknown)):
            for neighbour, axes in steps_from(costs, voxel, allow_unknown):
                into = weight(int(costs[neighbour]), allow_unknown) * math.sqrt(axes)
                flat = (int(np.ravel_multi_index(at, costs.shape)) for at in (voxel, neighbour))
                found.append((*flat, into))
    return found
