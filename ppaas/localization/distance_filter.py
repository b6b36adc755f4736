"""Distance filter: leaves out beams that end at people who crowd around a robot, since they do not determine its pose.

Fox, Burgard, Thrun, *Markov Localization for Mobile Robots in Dynamic Environments* (1999).
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.map_layers import MapLayers
from ppaas.geometry import Pose2D
from ppaas.localization.kernels.sight import stopped_short

NEAR, BEYOND = 2.0, 0.2
"""A beam ends at a person if it is shorter than `NEAR` and at least `BEYOND` shorter than in the map [m]."""

MANY = 0.25
"""Part of the beams above which the robot is taken to be in a crowd. A pose that is slightly off explains fewer."""


def ends_at_people(pose: Pose2D, points: NDArray[np.float64], layers: MapLayers) -> NDArray[np.bool_]:
    """Return a mask of the beams that end at people of a crowd; all False without a crowd.

    Parameters
    ----------
    pose : Pose2D
        Approximate pose of the robot in the map frame.
    points : (n, 2) array
        End points of beams in the robot's frame [m].
    layers : MapLayers
        The map; its ``distance`` is read.

    Returns
    -------
    (n,) bool array
    """
    people = np.zeros(len(points), dtype=np.bool_)
    near = points[:, 0] ** 2 + points[:, 1] ** 2 < NEAR**2
    if np.count_nonzero(near) > MANY * len(points):
        info = layers.grid.info
        origin = np.array(info.origin)
        short = stopped_short(np.array(pose), points[near], layers.distance, info.resolution, origin, BEYOND)
        if np.count_nonzero(short) > MANY * len(points):
            people[near] = short
    return people
