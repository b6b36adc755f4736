"""Lattices of places on a map, and the choice of the one whose largest connected part has the most places."""

import math
from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.maps.grid import GridInfo

PHASES = 4
"""Number of offsets along x, and along y, of which all pairs are tried."""

FINE_PHASES = 16
"""Largest number of offsets along an axis that are tried around the best pair."""

TURNED_SAMPLES = 2
"""Number of samples for each edge of a map cell, along moves that do not run along the rows of the map."""


class Lattice(NamedTuple):
    """Places at equal distances along x and y in the map frame, (columns,) and (rows,) float64 arrays [m]."""

    xs: NDArray[np.float64]
    ys: NDArray[np.float64]


class Moves(NamedTuple):
    """Free places of a lattice and moves between them, as ``Roadmap.of_moves`` takes them."""

    free: NDArray[np.bool_]
    in_rows: NDArray[np.bool_]
    in_columns: NDArray[np.bool_]


class Clear:
    """The part of a map where the centre of a robot may be.

    Parameters
    ----------
    mask : (h, w) bool array
        True in map cells where it may be; nowhere outside.
    info : GridInfo
        Geometry of the map.
    """

    def __init__(self, mask: NDArray[np.bool_], info: GridInfo) -> None:
        self._padded = np.pad(mask, 1)
        self._info = info

    @property
    def is_turned(self) -> bool:
        """Whether rows of the map do not run along the x axis of the map frame."""
        return self._info.origin.theta != 0.0

    def at(self, lattice: Lattice) -> NDArray[np.bool_]:
        """Return True for each place of a lattice where a robot may be, (rows, columns) bool."""
        info, (xs, ys) = self._info, lattice
        if self.is_turned:
            cells = info.to_cells(np.stack(np.meshgrid(xs, ys), axis=-1))
            rows, columns = cells[..., 0], cells[..., 1]
        else:
            rows = info.to_cells(np.stack([np.full_like(ys, info.origin.x), ys], axis=-1))[:, :1]
            columns = info.to_cells(np.stack([xs, np.full_like(xs, info.origin.y)], axis=-1))[:, 1]
        found: NDArray[np.bool_] = self._padded[_inside(rows, info.height), _inside(columns, info.width)]
        return found

    def moves(self, lattice: Lattice, spacing: float) -> Moves:
        """Return the free places of a lattice, and the moves on whose whole line a robot may be."""
        free, samples = self.at(lattice), self._samples(spacing)
        in_rows, in_columns = free[:, :-1] & free[:, 1:], free[:-1] & free[1:]
        for part in np.arange(1, samples) / samples * spacing:
            if not (in_rows.any() or in_columns.any()):
                break
            in_rows &= self.at(Lattice(lattice.xs[:-1] + part, lattice.ys))
            in_columns &= self.at(Lattice(lattice.xs, lattice.ys[:-1] + part))
        return Moves(free, in_rows, in_columns)

    def _samples(self, spacing: float) -> int:
        each = TURNED_SAMPLES if self.is_turned else 1
        return int(each * spacing / self._info.resolution) + 1


def _inside(index: NDArray[np.int64], size: int) -> NDArray[np.int64]:
    """Return indices into a padded axis; all outside of the axis become one of its borders."""
    return np.clip(index, -1, size) + 1


class Bounds(NamedTuple):
    """Smallest and largest x and y of a map in the map frame [m]."""

    least_x: float
    least_y: float
    most_x: float
    most_y: float

    @classmethod
    def of(cls, info: GridInfo) -> "Bounds":
        """Return the bounds of a map."""
        rows, columns = (-0.5, info.height - 0.5), (-0.5, info.width - 0.5)
        corners = info.to_world([(row, column) for row in rows for column in columns])
        return cls(*corners.min(axis=0).tolist(), *corners.max(axis=0).tolist())

    def lattice(self, spacing: float, x: float, y: float) -> Lattice:
        """Return the lattice whose squares cover the map, with offsets from 0 to 1 spacings along x and y."""
        xs = _places(self.least_x, self.most_x, spacing, x)
        return Lattice(xs, _places(self.least_y, self.most_y, spacing, y))

    def places(self, spacing: float) -> int:
        """Return the largest number of places of a lattice."""
        sides = (self.most_x - self.least_x, self.most_y - self.least_y)
        return math.prod(math.ceil(min(side / spacing, 1e9)) + 1 for side in sides)


def _places(least: float, most: float, spacing: float, offset: float) -> NDArray[np.float64]:
    first = least + (offset - 0.5) * spacing
    return first + spacing * np.arange(math.floor((most - first) / spacing + 0.5) + 1, dtype=np.float64)


def best_lattice(
    clear: Clear, bounds: Bounds, spacing: float, resolution: float, check: Callable[[], None]
) -> tuple[Lattice, Moves]:
    """Return the lattice whose largest connected part has the most places, and its moves.

    All pairs of some offsets along x and y are tried, then many offsets along y beside the best one along x, then the
    other way round. Of lattices that are as good, the first is returned.
    """
    fine = min(FINE_PHASES, max(1, math.ceil(spacing / resolution)))
    coarse, every = _offsets(PHASES), _offsets(fine)
    best, most = (0.5, 0.5), -1

    def look_at(offsets: Iterable[tuple[float, float]]) -> None:
        nonlocal best, most
        for offset in offsets:
            check()
            size = largest_part(clear.moves(bounds.lattice(spacing, *offset), spacing))
            if size > most:
                best, most = offset, size

    look_at((x, y) for y in coarse for x in coarse)
    look_at([(best[0], y) for y in every])
    look_at([(x, best[1]) for x in every])
    lattice = bounds.lattice(spacing, *best)
    return lattice, clear.moves(lattice, spacing)


def _offsets(count: int) -> list[float]:
    return [(k + 0.5) / count for k in range(count)]


def largest_part(moves: Moves) -> int:
    """Return the number of places of the largest part of a lattice that moves connect."""
    if not moves.free.any():
        return 0
    numbers = np.arange(moves.free.size).reshape(moves.free.shape)
    one = np.concatenate([numbers[:, :-1][moves.in_rows], numbers[:-1][moves.in_columns]])
    other = np.concatenate([numbers[:, 1:][moves.in_rows], numbers[1:][moves.in_columns]])
    root = numbers.ravel().copy()
    while len(one):
        np.minimum.at(root, np.maximum(one, other), np.minimum(one, other))
        while not np.array_equal(up := root[root], root):
            root = up
        one, other = root[one], root[other]
        apart = one != other
        one, other = one[apart], other[apart]
    return int(np.bincount(root).max())
