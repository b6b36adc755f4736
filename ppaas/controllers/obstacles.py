"""Obstacles of a local costmap, and the clearance that a robot must keep from them."""

import math

import numpy as np

from ppaas.controllers.kernels.clearance import Field, RobotOutline, clearance, clearance_along
from ppaas.cost_values import LETHAL_OBSTACLE, NO_INFORMATION
from ppaas.costmap.costmap import Costmap
from ppaas.geometry import Pose2D
from ppaas.maps.kernels.distance import distance_serial

CORNER = math.sqrt(0.5)
"""Distance from the centre of a cell to its corners [cells]."""

ROUNDING = 1e-4
"""Slack of a clearance, so that a robot that does not move keeps it in spite of rounding [m]."""


def distance_to_lethal(costmap: Costmap, *, allow_unknown: bool) -> Field:
    """Return the distance from the centre of each cell to the centre of the nearest lethal cell [m].

    Parameters
    ----------
    costmap : Costmap
    allow_unknown : bool
        Whether unknown cells are not lethal.

    Returns
    -------
    (height, width) array
        Larger than the costmap's diagonal if there is no lethal cell.
    """
    lethal = costmap.data == LETHAL_OBSTACLE
    if not allow_unknown:
        lethal |= costmap.data == NO_INFORMATION
    return distance_serial(lethal.view(np.uint8), costmap.info.resolution)


def clearance_to_keep(distance: Field, resolution: float, body: RobotOutline, pose: Pose2D) -> float:
    """Return the clearance to the centres of lethal cells that a robot must keep [m].

    It is half the diagonal of a cell, or the current clearance if that is less: a robot that already touches something
    may stay or move away, but not nearer.

    Parameters
    ----------
    distance : (height, width) array
        Distances to obstacles [m].
    resolution : float
        Edge of a cell [m].
    body : RobotOutline
        Outline of the robot.
    pose : Pose2D
        In the frame of the grid.
    """
    here = clearance(distance, resolution, body, pose.x, pose.y, math.cos(pose.theta), math.sin(pose.theta))
    return min(CORNER * resolution, here - ROUNDING)


class Room:
    """Free space around a robot.

    Parameters
    ----------
    costmap : Costmap
    body : RobotOutline
        Outline of the robot.
    pose : Pose2D
        Start of motions, in the frame of the costmap.
    allow_unknown : bool
        Whether unknown cells are free.

    Attributes
    ----------
    distance : (height, width) array
        Distances to obstacles [m].
    start : Pose2D
        Start of motions, in the frame of the grid.
    least : float
        Clearance to the centres of lethal cells that must be kept [m].
    """

    def __init__(self, costmap: Costmap, body: RobotOutline, pose: Pose2D, *, allow_unknown: bool) -> None:
        self._body, self._resolution = body, costmap.info.resolution
        self.distance = distance_to_lethal(costmap, allow_unknown=allow_unknown)
        self.start = costmap.info.origin.inverse() @ pose
        self.least = clearance_to_keep(self.distance, self._resolution, body, self.start)

    def is_for(self, length: float, turn: float) -> bool:
        """Return whether the robot can drive along an arc of a length [m] and a turn [rad]."""
        x, y, theta = map(float, self.start)
        motion = (float(length), float(turn))
        free = clearance_along(self.distance, self._resolution, self._body, (x, y, theta), motion)
        return bool(free >= self.least)
