"""Barrier that closes a line on a map and opens again, such as a door: a body in the way, and a wall to sensors."""

import math

import numpy as np
import pymunk
from numpy.typing import NDArray

from ppaas.maps.grid import GridInfo
from ppaas.polygons import distances_to_edges
from robots.sim.walls import wall_of

Segment = tuple[tuple[float, float], tuple[float, float]]
"""Both ends of a line: x, y [m]."""

MARGIN = 0.05
"""Gap to a body at which it is still in the way of what closes [m]."""


class Barrier:
    """Line of cells that is closed or open; it is open at first.

    Parameters
    ----------
    space : pymunk.Space
        Space of the world.
    occupied : (height, width) bool array
        Occupied cells of the world, as sensors see them: those of the line are among them while it is closed.
    info : GridInfo
        Resolution and origin of the map.
    ends : Segment
        Both ends of the line; what is outside of the map, or in a wall, stays as it is.
    """

    def __init__(self, space: pymunk.Space, occupied: NDArray[np.bool_], info: GridInfo, ends: Segment) -> None:
        self.is_closed = False
        self._space, self._occupied = space, occupied
        self._ends = np.array(ends[0]), np.array(ends[1])
        self._reach = info.resolution + MARGIN
        mask = cells_between(info, ends) & ~occupied
        self._cells = np.nonzero(mask)
        self._body, self._shapes = wall_of(mask, info)

    def close(self) -> None:
        """Close it, whatever is in the way: ask `is_blocked_by` before."""
        if not self.is_closed:
            self.is_closed = True
            self._occupied[self._cells] = True
            self._space.add(self._body, *self._shapes)

    def open(self) -> None:
        """Open it."""
        if self.is_closed:
            self.is_closed = False
            self._occupied[self._cells] = False
            self._space.remove(self._body, *self._shapes)

    def is_blocked_by(self, places: NDArray[np.float64], radius: float) -> bool:
        """Return whether one of several discs is in its way.

        Parameters
        ----------
        places : (n, 2) array
            Centres [m].
        radius : float
            Radius of the discs [m].
        """
        return bool((distances_to_edges(*self._ends, places) < radius + self._reach).any())


def cells_between(info: GridInfo, ends: Segment) -> NDArray[np.bool_]:
    """Return a mask of the cells of a line, each of which has an edge in common with the next."""
    steps = max(math.ceil(4.0 * math.dist(*ends) / info.resolution), 1)
    parts = np.linspace(0.0, 1.0, steps + 1)[:, np.newaxis]
    cells = info.to_cells((1.0 - parts) * np.array(ends[0]) + parts * np.array(ends[1]))
    corners = np.stack((cells[:-1, 0], cells[1:, 1]), axis=1)
    every = np.concatenate((cells, corners))
    inside = every[((every >= 0) & (every < info.shape)).all(axis=1)]
    mask: NDArray[np.bool_] = np.zeros(info.shape, bool)
    mask[inside[:, 0], inside[:, 1]] = True
    return mask
