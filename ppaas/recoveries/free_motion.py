"""Collision check of motions that follow no plan, such as backing up."""

import math

import numpy as np

from ppaas.controllers.base import Velocity
from ppaas.controllers.motion import advance
from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE
from ppaas.costmap.costmap import Costmap
from ppaas.geometry import Pose2D
from ppaas.recoveries.base import Fits

WAY_OUT = 0.1
"""Distance within which a robot that stands too near to an obstacle must leave it [m]."""


def is_free(costmap: Costmap, pose: Pose2D, velocity: Velocity, seconds: float, fits: Fits | None = None) -> bool:
    """Return whether a robot can keep a velocity for a time without touching anything.

    A robot within the inscribed radius of an obstacle, for example of a person who came near, may leave it: inscribed
    cells are ignored for a distance of at most `WAY_OUT`. So a robot between two obstacles stays where it is.

    Parameters
    ----------
    costmap : Costmap
        Local costmap; unknown cells, and cells outside it, are not free.
    pose : Pose2D
        Pose of the robot in the frame of the costmap.
    velocity : Velocity
        Velocity, kept along an arc.
    seconds : float
        Duration of the motion [s].
    fits : callable, optional
        Checks the outline of a robot that is not round.
    """
    speed = abs(velocity.linear)
    if speed == 0.0:
        return True
    leaving = costmap.costs_at([pose[:2]])[0] == INSCRIBED_INFLATED_OBSTACLE
    length = max(speed * seconds, WAY_OUT) if leaving else speed * seconds
    count = math.ceil(length / (0.5 * costmap.info.resolution)) + 1
    distances = np.linspace(0.0, length, count)
    poses = [advance(pose, velocity, distance / speed) for distance in distances.tolist()]
    if fits is not None and not all(map(fits, poses)):
        return False
    costs = costmap.costs_at([each[:2] for each in poses])
    blocked = costs >= INSCRIBED_INFLATED_OBSTACLE
    if leaving:
        blocked &= (distances >= WAY_OUT) | (costs > INSCRIBED_INFLATED_OBSTACLE)
    return not blocked.any()
