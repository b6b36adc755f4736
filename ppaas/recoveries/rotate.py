"""Turns once round on the spot, so that the laser sees what is behind (``rotate_recovery.cpp``)."""

import math
from typing import Any, ClassVar

from ppaas.controllers.base import Velocity
from ppaas.errors import InvalidParameter
from ppaas.geometry import wrap_angle
from ppaas.parameters import Parameters, read_parameters
from ppaas.recoveries.base import NotNegative, Positive, Recovery, RecoveryFailed, RecoveryRequest


class RotateParameters(Parameters, frozen=True):
    """Parameters of ``rotate_recovery``.

    Parameters
    ----------
    max_rotational_vel, min_in_place_rotational_vel : float
        Fastest and slowest turn [rad/s].
    acc_lim_th : float
        Of braking [rad/s²].
    rotation_patience : float
        How long a turn may take before it is given up [s].
    """

    max_rotational_vel: Positive = 1.0
    min_in_place_rotational_vel: NotNegative = 0.4
    acc_lim_th: Positive = 3.2
    rotation_patience: Positive = 20.0

    def __post_init__(self) -> None:
        """Check that the slowest is no faster than the fastest."""
        if self.min_in_place_rotational_vel > self.max_rotational_vel:
            raise InvalidParameter("min_in_place_rotational_vel must not be above max_rotational_vel")


class RotateRecovery(Recovery):
    """Turns once round on the spot.

    As fast as the rest of the turn lets it brake. A round robot that turns on the spot touches nothing it did not
    touch before, so nothing is checked.

    Parameters
    ----------
    **parameters
        The fields of `RotateParameters`.
    """

    name: ClassVar[str] = "rotate_recovery"
    purpose: ClassVar[str] = "Turns once round on the spot, so that the laser sees what is behind."

    def __init__(self, **parameters: Any) -> None:
        self.parameters = read_parameters(RotateParameters, self.name, parameters)
        self._left = 0.0
        self._heading = 0.0
        self._began = 0.0

    def start(self, request: RecoveryRequest) -> None:
        """Take note of the heading."""
        self._left = 2.0 * math.pi
        self._heading = request.pose.theta
        self._began = request.now

    def step(self, request: RecoveryRequest) -> Velocity | None:
        """Turn on, until once round.

        Raises
        ------
        RecoveryFailed
            It takes too long.
        """
        p = self.parameters
        self._left -= wrap_angle(request.pose.theta - self._heading)
        self._heading = request.pose.theta
        if self._left <= 0.0:
            return None
        if request.now - self._began > p.rotation_patience:
            raise RecoveryFailed(f"{self._left:.1f} rad of the turn were left after {p.rotation_patience:g} s")
        speed = math.sqrt(2.0 * p.acc_lim_th * self._left)
        return Velocity(0.0, min(max(speed, p.min_in_place_rotational_vel), p.max_rotational_vel))
