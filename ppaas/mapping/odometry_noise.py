"""Noise of an odometry step, with gmapping's parameters."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.mapping.parameters import SlamParameters
from ppaas.planar_poses import PoseArray

SLACK, FASTEST = 1.0, 5.0
"""Odometry was reset if it jumped by more than `SLACK` [m] plus what `FASTEST` [m/s] allows."""


def resets(stamps: NDArray[np.float64], odometry: PoseArray) -> NDArray[np.bool_]:
    """Return whether the odometry was reset before each scan (n,), because no robot moves that far in that time.

    Parameters
    ----------
    stamps : (n,) array
        Times of the scans [s].
    odometry : (n, 3) array
    """
    found = np.zeros(len(stamps), np.bool_)
    apart = np.hypot(*np.diff(odometry[:, :2], axis=0).T)
    found[1:] = apart > SLACK + FASTEST * np.maximum(np.diff(stamps), 0.0)
    return found


def odometry_deviations(step: Pose2D, parameters: SlamParameters) -> tuple[float, float, float]:
    """Return the standard deviations of x, y [m] and theta [rad] of an odometry step, in its own frame.

    Parameters
    ----------
    step : Pose2D
        Motion of the robot.
    parameters : SlamParameters
        ``srr``, ``srt``, ``str``, ``stt``, ``odometry_deviation`` and ``odometry_heading_deviation``.
    """
    distance, turn = math.hypot(step.x, step.y), abs(step.theta)
    place = parameters.odometry_deviation + parameters.srr * distance + parameters.srt * turn
    heading = parameters.odometry_heading_deviation + parameters.str * distance + parameters.stt * turn
    return place, place, heading
