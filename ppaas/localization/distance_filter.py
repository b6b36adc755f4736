"""Beams that end at people who crowd around a robot: they say nothing of where it is.

As the distance filter in Fox, Burgard, Thrun, *Markov Localization for Mobile Robots in Dynamic Environments* (1999).
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.map_layers import MapLayers
from ppaas.geometry import Pose2D
from ppaas.localization.kernels.sight import stopped_short

NEAR, BEYOND = 2.0, 0.2
"""A beam ended at somebody if it was shorter than this, and the map lets it go so much farther at least [m]."""

MANY = 0.25
"""There is a crowd where more than this part of the beams ended so. Fewer do where the pose is a little off, too."""


def at_people(pose: Pose2D, points: NDArray[np.float64], layers: MapLayers) -> NDArray[np.bool_]:
    """Tell which beams ended at people of a crowd; none where there is no crowd.

    Parameters
    ----------
    pose : Pose2D
        About where the robot is, in the map frame.
    points : (n, 2) array
        Where beams ended, in the robot's frame [m].
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
