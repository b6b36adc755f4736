"""What of a local costmap a robot may not touch."""

import math

import numpy as np

from ppaas.controllers.kernels.clearance import Body, Field, clearance, clearance_along
from ppaas.cost_values import LETHAL_OBSTACLE, NO_INFORMATION
from ppaas.costmap.costmap import Costmap
from ppaas.geometry import Pose2D
from ppaas.maps.kernels.distance import distance_serial

CORNER = math.sqrt(0.5)
"""From the middle of a cell, by which it is told, to its corners [cells]."""
ROUNDING = 1e-4
"""A robot that stays where it is has kept its clearance [m]."""


def distance_to_lethal(costmap: Costmap, *, allow_unknown: bool) -> Field:
    """Return how far the middle of each cell is from that of the nearest lethal one [m].

    Parameters
    ----------
    costmap : Costmap
    allow_unknown : bool
        Whether unknown cells are none of these.

    Returns
    -------
    (height, width) array
        More than the costmap is long where there is none.
    """
    lethal = costmap.data == LETHAL_OBSTACLE
    if not allow_unknown:
        lethal |= costmap.data == NO_INFORMATION
    return distance_serial(lethal.view(np.uint8), costmap.info.resolution)


def clearance_to_keep(distance: Field, resolution: float, body: Body, pose: Pose2D) -> float:
    """Return what a robot must keep clear of the middles of cells [m]: their corners, or what it does not touch yet.

    A robot that touches something already may stay, or get away, and come no nearer to it.

    Parameters
    ----------
    distance : (height, width) array
        To obstacles [m].
    resolution : float
        Edge of a cell [m].
    body : Body
    pose : Pose2D
        In the frame of the grid.
    """
    here = clearance(distance, resolution, body, pose.x, pose.y, math.cos(pose.theta), math.sin(pose.theta))
    return min(CORNER * resolution, here - ROUNDING)


class Room:
    """What a robot has around it to move in.

    Parameters
    ----------
    costmap : Costmap
    body : Body
        Of the robot.
    pose : Pose2D
        Where it begins to move, in the frame of the costmap.
    allow_unknown : bool
        Whether unknown cells are free.

    Attributes
    ----------
    distance : (height, width) array
        To obstacles [m].
    start : Pose2D
        Where it begins, in the frame of the grid.
    least : float
        What it must keep clear of the middles of cells [m].
    """

    def __init__(self, costmap: Costmap, body: Body, pose: Pose2D, *, allow_unknown: bool) -> None:
        self._body, self._resolution = body, costmap.info.resolution
        self.distance = distance_to_lethal(costmap, allow_unknown=allow_unknown)
        self.start = costmap.info.origin.inverse() @ pose
        self.least = clearance_to_keep(self.distance, self._resolution, body, self.start)

    def is_for(self, length: float, turn: float) -> bool:
        """Tell whether the robot can drive along an arc so long [m] that turns it so far [rad]."""
        x, y, theta = map(float, self.start)
        motion = (float(length), float(turn))
        free = clearance_along(self.distance, self._resolution, self._body, (x, y, theta), motion)
        return bool(free >= self.least)
