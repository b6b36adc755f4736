"""Parameters of local planners for a Jackal."""

import math
from typing import Any

from benchmarks.navigation.barn.jackal import FOOTPRINT, LENGTH, MAX_ANGULAR, MAX_LINEAR, WIDTH
from benchmarks.navigation.barn.navigator import Navigator
from ppaas.geometry import Pose2D
from robots.sim.drivetrain import DrivetrainModel

REVERSE = -0.5
"""Maximum reverse velocity [m/s]."""


def make_navigator(planner: str, goal: Pose2D, drive: DrivetrainModel) -> Navigator:
    """Return a navigator that uses a local planner.

    Parameters
    ----------
    planner : str
        Name of the plug-in; planners other than ``mppi`` use their defaults and the robot's radius.
    goal : Pose2D
        Goal relative to the robot's start [m].
    drive : DrivetrainModel
        Known properties of the motors: speeds, accelerations, delay and lag.
    """
    return Navigator(goal, planner, _parameters(planner, drive))


def _parameters(planner: str, drive: DrivetrainModel) -> dict[str, Any]:
    if planner == "mppi":
        return {
            "max_vel_x": MAX_LINEAR, "min_vel_x": REVERSE, "max_vel_theta": MAX_ANGULAR,
            "acc_lim_x": drive.acc_linear, "acc_lim_theta": drive.acc_angular,
            "command_delay": drive.delay, "motor_lag": drive.lag,
            "footprint": FOOTPRINT, "robot_radius": math.hypot(LENGTH, WIDTH) / 2,
        }  # fmt: skip
    return {"robot_radius": WIDTH / 2}
