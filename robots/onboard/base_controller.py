"""The base controller: from ``cmd_vel`` to the velocity that the base shall drive now."""

import math
from dataclasses import dataclass

from ppaas.clock import Clock, monotonic
from ppaas.controllers.base import Velocity
from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.messages.geometry_msgs import Twist

STOP = Velocity(0.0, 0.0)


@dataclass(frozen=True, slots=True)
class BaseLimits:
    """What the base may be told to do.

    Parameters
    ----------
    max_linear : float
        Fastest forwards and backwards [m/s].
    max_angular : float
        Fastest turn [rad/s].
    timeout : float
        Without a ``cmd_vel`` for so long the base stops [s].

    Raises
    ------
    InvalidParameter
        One of them is not a positive number.
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
    """Holds the last command and forgets it when it is too old: a robot that the cloud lost must not drive on.

    Parameters
    ----------
    limits : BaseLimits, optional
        Of the base.
    clock : callable
        Monotonic seconds.
    """

    def __init__(self, limits: BaseLimits | None = None, clock: Clock = monotonic) -> None:
        self.limits = limits or BaseLimits()
        self._clock = clock
        self._velocity = STOP
        self._commanded = -math.inf

    def command(self, twist: Twist) -> None:
        """Take a command; what is too fast is clamped.

        Raises
        ------
        InvalidInput
            Not finite. The command before it is forgotten: who sends such things is not to be trusted to go on.
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
        """Return what the base shall drive now."""
        fresh = self._clock() - self._commanded <= self.limits.timeout
        return self._velocity if fresh else STOP
