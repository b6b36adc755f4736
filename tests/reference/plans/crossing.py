"""Slow, obvious twin of `ppaas.plans.reuse.crossed_cells`: samples many points of a path."""

import itertools

import numpy as np

from ppaas.maps.grid import GridInfo

Cell = tuple[int, int]


def cells_on(info: GridInfo, points: list[list[float]], pieces: int = 1000) -> set[Cell]:
    """Return the cells of ``pieces`` points on each straight line of a path.

    Points on a border between cells, within rounding, do not count.
    """
    found = set()
    for (x0, y0), (x1, y1) in itertools.pairwise(points):
        fraction = np.linspace(0.0, 1.0, pieces + 1)
        line = np.stack((x0 + (x1 - x0) * fraction, y0 + (y1 - y0) * fraction), axis=1)
        off = 1e-6 * info.resolution
        nearby = [info.to_cells(line + shift) for shift in ((off, off), (-off, off), (off, -off), (-off, -off))]
        inside = np.all([np.all(each == nearby[0], axis=1) for each in nearby], axis=0)
        found |= {(row, column) for row, column in nearby[0][inside].tolist()}
    return found
