"""Whether a robot may move blindly: backwards, say, where no plan leads."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.controllers.base import Velocity
from ppaas.controllers.motion import advance
from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE, NO_INFORMATION
from ppaas.costmap.costmap import Costmap
from ppaas.geometry import Pose2D

WAY_OUT = 0.1
"""A robot that stands nearer to an obstacle than it may must be clear of it after so much [m]."""


def is_free(costmap: Costmap, pose: Pose2D, velocity: Velocity, seconds: float) -> bool:
    """Tell whether a round robot that keeps a velocity for some time touches nothing.

    Who stands within the inscribed radius of an obstacle, as in front of one that came near, may leave it: such cells
    are passed over, but not longer than `WAY_OUT`. So a robot between two obstacles stays where it is.

    Parameters
    ----------
    costmap : Costmap
        Local; unknown cells, and all beyond its edge, are not free.
    pose : Pose2D
        Of the robot, in the frame of the costmap.
    velocity : Velocity
        Kept along an arc.
    seconds : float
        For so long.
    """
    speed = abs(velocity.linear)
    if speed == 0.0:
        return True
    leaving = _costs(costmap, [pose])[0] == INSCRIBED_INFLATED_OBSTACLE
    length = max(speed * seconds, WAY_OUT) if leaving else speed * seconds
    count = math.ceil(length / (0.5 * costmap.info.resolution)) + 1
    ways = np.linspace(0.0, length, count)
    costs = _costs(costmap, [advance(pose, velocity, way / speed) for way in ways.tolist()])
    blocked = costs >= INSCRIBED_INFLATED_OBSTACLE
    if leaving:
        blocked &= (ways >= WAY_OUT) | (costs > INSCRIBED_INFLATED_OBSTACLE)
    return not blocked.any()


def _costs(costmap: Costmap, poses: list[Pose2D]) -> NDArray[np.uint8]:
    cells = costmap.info.to_cells([pose[:2] for pose in poses])
    inside = ((cells >= 0) & (cells < costmap.info.shape)).all(axis=1)
    costs = np.full(len(poses), NO_INFORMATION, np.uint8)
    costs[inside] = costmap.data[tuple(cells[inside].T)]
    return costs
