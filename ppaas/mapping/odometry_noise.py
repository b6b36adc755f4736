"""Noise of an odometry step, with gmapping's parameters."""

import math

from ppaas.geometry import Pose2D
from ppaas.mapping.parameters import SlamParameters


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
