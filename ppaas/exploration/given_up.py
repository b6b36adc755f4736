"""Places that a robot gave up: frontiers that it could not reach, or that stayed when it had seen them."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.planar_poses import moved_points

TILE = 0.25
"""Edge of the tiles by which places are remembered [m]. A loop closure moves a frontier by less, mostly."""

MOST_TILES = 20_000
"""Tiles that are remembered; the oldest are forgotten."""

Tile = tuple[int, int]


class GivenUp:
    """Frontiers by the tiles that they are in; a frontier is given up if most of its cells are in or beside these.

    Parameters
    ----------
    tiles : iterable of (int, int)
        Tiles at the start.
    """

    def __init__(self, tiles: Iterable[Tile] = ()) -> None:
        self._tiles: dict[Tile, None] = dict.fromkeys(tiles)
        self._near: set[Tile] | None = None

    @property
    def tiles(self) -> list[Tile]:
        """The tiles, oldest first."""
        return list(self._tiles)

    def add(self, points: NDArray[np.float64]) -> None:
        """Give up a frontier with cells at (n, 2) points x, y [m]."""
        self._tiles |= dict.fromkeys(map(tuple, _tiles_of(points).tolist()))
        for oldest in list(self._tiles)[: max(0, len(self._tiles) - MOST_TILES)]:
            del self._tiles[oldest]
        self._near = None

    def moved(self, motion: Pose2D) -> "GivenUp":
        """Return the same places after a motion of the map frame."""
        moved = GivenUp()
        if self._tiles:
            centres = (np.array(list(self._tiles), np.float64) + 0.5) * TILE
            moved.add(moved_points(motion, centres))
        return moved

    def covers(self, points: NDArray[np.float64]) -> bool:
        """Return whether a frontier with cells at (n, 2) points x, y [m] is given up."""
        if not self._tiles:
            return False
        if self._near is None:
            steps = (-1, 0, 1)
            self._near = {(x + right, y + up) for x, y in self._tiles for right in steps for up in steps}
        within = sum(tile in self._near for tile in map(tuple, _tiles_of(points).tolist()))
        return 2 * within > len(points)


def thinned(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the centres (m, 2) of the tiles that (n, 2) points are in, x, y [m]: they give up the same places."""
    centres: NDArray[np.float64] = (np.unique(_tiles_of(points), axis=0).astype(np.float64) + 0.5) * TILE
    return centres


def _tiles_of(points: NDArray[np.float64]) -> NDArray[np.int64]:
    return np.floor(points / TILE).astype(np.int64)
