"""Motion of a laser from the odometry of the robot that carries it, and the noise of the odometry."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ppaas.geometry import Pose2D
from ppaas.mapping.parameters import SlamParameters
from ppaas.planar_poses import PoseArray, compose, relative

MOST = np.array((3.0, 3.0, 4.0))
"""Largest velocities that the odometry is believed: x, y [m/s], theta [rad/s]; odometry jumps exceed them."""

LEAST_TIME = 0.05
"""Shortest time between two poses from which a velocity is calculated [s]."""


def laser_step(before: Pose2D, after: Pose2D, mount: Pose2D) -> Pose2D:
    """Return the pose of the laser after a step in its frame before.

    Parameters
    ----------
    before, after : Pose2D
        Odometry: poses of the robot.
    mount : Pose2D
        Pose of the laser on the robot.
    """
    return mount.inverse() @ (before.inverse() @ after) @ mount


def velocity(step: Pose2D, seconds: float) -> NDArray[np.float64]:
    """Return the mean velocity of a step of the laser, in its frame after the step; each component at most `MOST`.

    Parameters
    ----------
    step : Pose2D
        See `laser_step`.
    seconds : float
        Duration of the step.

    Returns
    -------
    (3,) array
        x, y [m/s], theta [rad/s].
    """
    found: NDArray[np.float64] = np.clip(-np.array(step.inverse()) / max(seconds, LEAST_TIME), -MOST, MOST)
    return found


def velocities(times: ArrayLike, odometry: ArrayLike, mount: Pose2D) -> NDArray[np.float64]:
    """Return the velocity of the laser at each scan of a log, from the scans before and after it in time.

    Parameters
    ----------
    times : (n,) array
        Times of the scans [s], in any order.
    odometry : (n, 3) array
        Poses of the robot: x, y [m], theta [rad].
    mount : Pose2D
        Pose of the laser on the robot.

    Returns
    -------
    (n, 3) float64 array
        x, y [m/s], theta [rad/s] in the frame of the laser; 0 for the first and the last scan.
    """
    stamps, robot = np.asarray(times, np.float64), np.asarray(odometry, np.float64)
    found = np.zeros((len(stamps), 3))
    order = np.argsort(stamps, kind="stable")
    if len(order) > 2:
        laser = compose(robot[order], np.asarray(mount, np.float64))
        seconds = np.maximum(stamps[order[2:]] - stamps[order[:-2]], LEAST_TIME)
        steps = relative(laser[1:-1], laser[2:]) - relative(laser[1:-1], laser[:-2])
        found[order[1:-1]] = np.clip(steps / seconds[:, np.newaxis], -MOST, MOST)
    return found


# -- noise of an odometry step, with gmapping's parameters -------------------------------------------------------------

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
