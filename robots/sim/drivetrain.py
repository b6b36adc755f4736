"""Drivetrain of a simulated base: command delay, motor lag, acceleration limits and wheel slip."""

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from ppaas.controllers.base import Velocity


@dataclass(frozen=True, slots=True)
class DrivetrainModel:
    """Parameters of a drivetrain.

    Parameters
    ----------
    max_linear, max_angular : float
        Speed limits [m/s, rad/s].
    acc_linear, acc_angular : float
        Acceleration limits [m/s², rad/s²].
    slip_linear, slip_angular : float
        Standard deviation of the slip, as a fraction of the motion.
    slip_time : float
        Correlation time of the slip [s].
    lag : float
        Time constant of the motors [s].
    delay : float
        Delay of commands [s].
    """

    max_linear: float
    max_angular: float
    acc_linear: float
    acc_angular: float
    slip_linear: float = 0.0
    slip_angular: float = 0.0
    slip_time: float = 1.0
    lag: float = 0.0
    delay: float = 0.0


class Drivetrain:
    """Motors and wheels of one robot.

    Parameters
    ----------
    model : DrivetrainModel
        Parameters.
    rng : numpy.random.Generator
        Random generator of the slip.
    """

    def __init__(self, model: DrivetrainModel, rng: np.random.Generator) -> None:
        self.model = model
        self.wheels = Velocity()
        self._target = Velocity()
        self._pending: deque[tuple[float, Velocity]] = deque()
        self._now = 0.0
        self._slip = np.zeros(2)
        self._rng = rng

    def command(self, velocity: Velocity) -> None:
        """Set the target velocity; it takes effect after the delay, within the acceleration limits."""
        self._pending.append((self._now + self.model.delay, velocity))

    def turn(self, dt: float) -> Velocity:
        """Simulate a step of ``dt`` [s]; return the velocity of the body during the step."""
        model = self.model
        while self._pending and self._pending[0][0] <= self._now + 1e-9:
            self._target = self._pending.popleft()[1]
        self._now += dt
        response = -math.expm1(-dt / model.lag) if model.lag > 0.0 else 1.0
        self.wheels = Velocity(
            _approach(self.wheels.linear, self._target.linear, model.acc_linear * dt, model.max_linear, response),
            _approach(self.wheels.angular, self._target.angular, model.acc_angular * dt, model.max_angular, response),
        )
        # The slip is an Ornstein-Uhlenbeck process: correlated over `slip_time`, with constant standard deviation.
        fade = math.exp(-dt / model.slip_time)
        sigma = np.array((model.slip_linear, model.slip_angular))
        self._slip = fade * self._slip + sigma * math.sqrt(1.0 - fade**2) * self._rng.standard_normal(2)
        linear, angular = self._slip.tolist()
        return Velocity(self.wheels.linear * (1.0 + linear), self.wheels.angular * (1.0 + angular))


def _approach(current: float, target: float, max_change: float, limit: float, response: float) -> float:
    """Return the next speed of a first-order lag towards the target, within the limits of speed and acceleration."""
    wanted = current + response * (min(max(target, -limit), limit) - current)
    return min(max(wanted, current - max_change), current + max_change)
