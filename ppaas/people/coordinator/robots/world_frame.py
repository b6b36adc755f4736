"""Step 2: torso coordinates in the world frame."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D

Array = NDArray[np.float64]


def to_world(pose: Pose2D, pose_covariance: Array, torsos: Array, covariances: Array) -> tuple[Array, Array]:
    """Return torsos in the frame of the map, with the uncertainty of the robot's own pose.

    The paper: "all torso coordinates to the world frame".

    Parameters
    ----------
    pose : Pose2D
        Pose of the robot in the map.
    pose_covariance : (3, 3) array
        Covariance of x, y [m²] and yaw [rad²] in the frame of the map.
    torsos : (n, 2) array
        Positions in the frame of the robot [m].
    covariances : (n, 2, 2) array
        Their covariances in that frame [m²].

    Returns
    -------
    positions : (n, 2) array
    covariances : (n, 2, 2) array
        To first order: turned into the map, plus the covariances of the position and of the yaw times the lever.
    """
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    turn = np.array([[c, -s], [s, c]])
    lever = torsos @ turn.T
    jacobian = jacobian_of(lever)
    spread = turn @ covariances @ turn.T + jacobian @ pose_covariance @ np.swapaxes(jacobian, 1, 2)
    return lever + np.array([pose.x, pose.y]), spread


def jacobian_of(levers: Array) -> Array:
    """Return the (n, 2, 3) derivatives of positions at (n, 2) levers [m] by the x, y and yaw of the robot."""
    jacobian = np.zeros((len(levers), 2, 3))
    jacobian[:, 0, 0] = jacobian[:, 1, 1] = 1.0
    jacobian[:, 0, 2], jacobian[:, 1, 2] = -levers[:, 1], levers[:, 0]
    return jacobian
