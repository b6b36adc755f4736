"""Recovery ``rotate_recovery``: a turn in place, so that the laser sees all around (``rotate_recovery.cpp``)."""

import math
from typing import Annotated, Any, ClassVar

import msgspec
import numpy as np

from ppaas.controllers.base import Velocity
from ppaas.errors import InvalidParameter
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.parameters import Parameters, read_parameters
from ppaas.recoveries.base import NotNegative, Positive, Recovery, RecoveryFailed, RecoveryRequest

AHEAD, STEP = 0.6, 0.1
"""Angle ahead of the robot in which its outline is checked, more than it needs to stop, and step of the check [rad]."""


class RotateParameters(Parameters, frozen=True):
    """Parameters of ``rotate_recovery``.

    Parameters
    ----------
    max_rotational_vel, min_in_place_rotational_vel : float
        Fastest and slowest turn [rad/s].
    acc_lim_th : float
        Deceleration [rad/s²].
    rotation_patience : float
        Time limit [s].
    spin_dist : float
        Turn to the left, or to the right if it is negative, as in Nav2's behaviour tree [rad].
    """

    max_rotational_vel: Positive = 1.0
    min_in_place_rotational_vel: NotNegative = 0.4
    acc_lim_th: Positive = 3.2
    rotation_patience: Positive = 20.0
    spin_dist: Annotated[float, msgspec.Meta(ge=-1e6, le=1e6)] = math.tau

    def __post_init__(self) -> None:
        """Check that the slowest turn is not faster than the fastest."""
        if self.min_in_place_rotational_vel > self.max_rotational_vel:
            raise InvalidParameter("min_in_place_rotational_vel must be at most max_rotational_vel")


class RotateRecovery(Recovery):
    """Turns the robot in place by ``spin_dist``, which is 360° by default, as fast as it can brake before the end.

    A round robot that turns in place touches nothing new; the outline of another one is checked ahead of the turn.

    Parameters
    ----------
    **parameters
        The fields of `RotateParameters`.
    """

    name: ClassVar[str] = "rotate_recovery"
    purpose: ClassVar[str] = "Turns in place by 360° or spin_dist, so that the laser sees all around."

    def __init__(self, **parameters: Any) -> None:
        self.parameters = read_parameters(RotateParameters, self.name, parameters)
        self._left = 0.0
        self._heading = 0.0
        self._began = 0.0

    def start(self, request: RecoveryRequest) -> None:
        """Record the heading and the time."""
        self._left = abs(self.parameters.spin_dist)
        self._heading = request.pose.theta
        self._began = request.now

    def step(self, request: RecoveryRequest) -> Velocity | None:
        """Turn until the angle is done.

        Raises
        ------
        RecoveryFailed
            The time limit has passed, or the outline of the robot would touch an obstacle.
        """
        p = self.parameters
        side = math.copysign(1.0, p.spin_dist)
        self._left -= side * wrap_angle(request.pose.theta - self._heading)
        self._heading = request.pose.theta
        if self._left <= 0.0:
            return None
        if request.now - self._began > p.rotation_patience:
            raise RecoveryFailed(f"{self._left:.1f} rad of the turn remained after {p.rotation_patience:g} s")
        ahead = np.arange(STEP, min(AHEAD, self._left + STEP), STEP)
        if request.fits is not None and not all(
            request.fits(request.pose @ Pose2D(0.0, 0.0, side * turn)) for turn in ahead.tolist()
        ):
            raise RecoveryFailed(f"there is no room for the {self._left:.1f} rad of the turn that remained")
        speed = math.sqrt(2.0 * p.acc_lim_th * self._left)
        return Velocity(0.0, side * min(max(speed, p.min_in_place_rotational_vel), p.max_rotational_vel))
