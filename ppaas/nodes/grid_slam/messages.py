"""Messages of mapping: the covariance and entropy of a pose."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.mapping.scan_tracker import Tracked
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Pose
from ppaas.messages.nav_msgs import MapMetaData, OccupancyGrid
from ppaas.nodes.frames import MAP
from ppaas.planar_poses import rotated, symmetric

LEAST_INFORMATION = np.diag((1e-2, 1e-2, 1e-2))
"""Information added to a pose's: 10 m and 10 rad, so that a covariance exists [1/m², 1/m², 1/rad²]."""


FIRST_INFORMATION = np.array((1e8, 0.0, 0.0, 1e8, 0.0, 1e8))
"""Information of the first pose, which defines the map frame: 0.1 mm, 0.1 mrad [1/m², 1/rad²]."""


def robot_covariance(information: NDArray[np.float64], laser: Pose2D, robot: Pose2D) -> NDArray[np.float64]:
    """Return the covariance of the robot's pose in the map frame from the information of its laser's pose.

    Parameters
    ----------
    information : (6,) array
        Information of the pose of the laser in its own frame.
    laser, robot : Pose2D
        Poses in the map frame.

    Returns
    -------
    (3, 3) array
        Covariance of x [m], y [m], theta [rad].
    """
    own = np.asarray(np.linalg.inv(symmetric(information) + LEAST_INFORMATION), np.float64)
    turned = rotated(own, laser.theta)
    lever = np.eye(3)
    lever[:2, 2] = laser.y - robot.y, robot.x - laser.x
    covariance: NDArray[np.float64] = lever @ turned @ lever.T
    return covariance


def tracked_covariance(tracked: Tracked, robot: Pose2D) -> NDArray[np.float64]:
    """Return the covariance (3, 3) of the robot's pose at a tracked scan; the first one has no information."""
    information = tracked.information if tracked.information.any() else FIRST_INFORMATION
    return robot_covariance(information, tracked.pose, robot)


def entropy_of(covariance: NDArray[np.float64]) -> float:
    """Return the entropy of a normal distribution of poses, from its (3, 3) covariance [nat]."""
    return 0.5 * (3.0 * math.log(2.0 * math.pi * math.e) + float(np.linalg.slogdet(covariance)[1]))


def no_map() -> OccupancyGrid:
    """Return the grid of a map that does not exist yet."""
    return OccupancyGrid(Header(frame_id=MAP), MapMetaData(0.0, 0, 0, Pose.of(Pose2D(0.0, 0.0))), [])
