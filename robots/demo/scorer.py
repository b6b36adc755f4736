"""Scores: the robots' true poses against their goals, and the cells of a map against the true world."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.maps.grid import OCCUPIED_THRESHOLD, UNKNOWN, GridMap
from robots.sim.contacts import ContactCounter
from robots.sim.robot import SimulatedRobot


class Scored(Protocol):
    """World or building with robots, and with their contacts."""

    robots: list[SimulatedRobot]
    contacts: ContactCounter


class Scorer:
    """Scores the robots of a world.

    Parameters
    ----------
    world : World or SimulatedBuilding
        World with the robots, which are identified by index.
    """

    def __init__(self, world: Scored) -> None:
        self._world = world

    def error(self, robot: int, goal: Pose2D) -> float:
        """Return the true distance of a robot to a goal [m]."""
        return self._world.robots[robot].base.pose.distance_to(goal)

    def distance(self, robot: int) -> float:
        """Return the true distance that a robot has travelled [m]."""
        return self._world.robots[robot].base.travelled

    def collisions(self, robot: int) -> int:
        """Return the number of contacts of a robot."""
        return self._world.contacts.total(robot)


# -- score of a map ----------------------------------------------------------------------------------------------------

_Mask = NDArray[np.bool_]


def wrong_cells(made: GridMap, truth: GridMap) -> tuple[int, int]:
    """Return how many known cells of a map are wrong, and how many cells are known.

    A cell is right if the true cell at its centre, or one of that cell's eight neighbours, is occupied or free like it:
    the edge of a wall may be off by one cell. Outside the true grid, everything is free.

    Parameters
    ----------
    made, truth : GridMap
        In the same frame.
    """
    cells = np.argwhere(made.data != UNKNOWN)
    occupied = made.data[cells[:, 0], cells[:, 1]] >= OCCUPIED_THRESHOLD
    walls = np.pad(truth.data >= OCCUPIED_THRESHOLD, 2)
    # One ring of free cells stands for all that is outside.
    at = np.clip(truth.info.to_cells(made.info.to_world(cells)) + 2, 1, np.array(walls.shape) - 2)
    right = np.where(occupied, _near(walls, at), _near(~walls, at))
    return int(np.count_nonzero(~right)), len(cells)


def _near(mask: _Mask, cells: NDArray[np.int64]) -> _Mask:
    """Return for (n, 2) cells whether they, or one of their eight neighbours, are in a mask."""
    steps = (-1, 0, 1)
    found: _Mask = np.any([mask[cells[:, 0] + up, cells[:, 1] + right] for up in steps for right in steps], axis=0)
    return found
