"""Base controller: turns ``cmd_vel`` into the velocity that the base must drive now."""

import math
from dataclasses import dataclass

from ppaas.clock import Clock, monotonic
from ppaas.controllers.base import Velocity
from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.messages.geometry_msgs import Twist

STOP = Velocity(0.0, 0.0)
"""Velocity of a base at rest."""


@dataclass(frozen=True, slots=True)
class BaseLimits:
    """Limits of the commands to the base.

    Parameters
    ----------
    max_linear : float
        Greatest linear speed, forwards and backwards [m/s].
    max_angular : float
        Greatest angular speed [rad/s].
    timeout : float
        Time without a ``cmd_vel`` after which the base stops [s].

    Raises
    ------
    InvalidParameter
        A limit is not a positive number.
    """

    max_linear: float = 0.65
    max_angular: float = 3.0
    timeout: float = 0.5

    def __post_init__(self) -> None:
        for name in self.__slots__:
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise InvalidParameter(f"{name} must be a positive number, not {value}")


class BaseController:
    """Applies the last command until it times out, so a robot that loses the cloud stops.

    Parameters
    ----------
    limits : BaseLimits, optional
        Limits of the base.
    clock : callable
        Monotonic seconds.
    """

    def __init__(self, limits: BaseLimits | None = None, clock: Clock = monotonic) -> None:
        self.limits = limits or BaseLimits()
        self._clock = clock
        self._velocity = STOP
        self._commanded = -math.inf

    def command(self, twist: Twist) -> None:
        """Accept a command; speeds above the limits are clamped.

        Raises
        ------
        InvalidInput
            The command is not finite. The base stops, because the sender cannot be trusted.
        """
        linear, angular = twist.linear.x, twist.angular.z
        if not (math.isfinite(linear) and math.isfinite(angular)):
            self._velocity = STOP
            raise InvalidInput(f"cmd_vel must be finite, not {linear} m/s and {angular} rad/s; the base stops")
        self._velocity = Velocity(
            min(max(linear, -self.limits.max_linear), self.limits.max_linear),
            min(max(angular, -self.limits.max_angular), self.limits.max_angular),
        )
        self._commanded = self._clock()

    def velocity(self) -> Velocity:
        """Return the velocity that the base must drive now."""
        fresh = self._clock() - self._commanded <= self.limits.timeout
        return self._velocity if fresh else STOP
