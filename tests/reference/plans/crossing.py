"""Slow, obvious twin of `ppaas.plans.reuse.crossed_cells`: the cells of very many points of a path."""

import itertools

import numpy as np

from ppaas.maps.grid import GridInfo

Cell = tuple[int, int]


def cells_on(info: GridInfo, points: list[list[float]], pieces: int = 1000) -> set[Cell]:
    """Return the cells in which a path lies: of so many points of each straight line.

    Points that lie on the border between cells but for rounding count for neither.
    """
    found = set()
    for (x0, y0), (x1, y1) in itertools.pairwise(points):
        part = np.linspace(0.0, 1.0, pieces + 1)
        line = np.stack((x0 + (x1 - x0) * part, y0 + (y1 - y0) * part), axis=1)
        off = 1e-6 * info.resolution
        nearby = [info.to_cells(line + shift) for shift in ((off, off), (-off, off), (off, -off), (-off, -off))]
        inside = np.all([np.all(each == nearby[0], axis=1) for each in nearby], axis=0)
        found |= {(row, column) for row, column in nearby[0][inside].tolist()}
    return found
