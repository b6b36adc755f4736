"""What is between a command and the motion of a base: a delay, motors that lag, and a floor that slips."""

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from ppaas.controllers.base import Velocity


@dataclass(frozen=True, slots=True)
class DrivetrainModel:
    """What the drive can.

    Parameters
    ----------
    max_linear, max_angular : float
        [m/s, rad/s]; it goes no faster, whatever it is told.
    acc_linear, acc_angular : float
        [m/s², rad/s²].
    slip_linear, slip_angular : float
        Standard deviation of the part of a motion that the wheels lose or gain on the floor.
    slip_time : float
        Seconds for which the floor stays much the same under the wheels.
    lag : float
        Time constant of the motors [s].
    delay : float
        Until a command reaches the motors [s].
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
        What they can.
    rng : numpy.random.Generator
        Of the floor.
    """

    def __init__(self, model: DrivetrainModel, rng: np.random.Generator) -> None:
        self.model = model
        self.wheels = Velocity()
        self._target = Velocity()
        self._under_way: deque[tuple[float, Velocity]] = deque()
        self._now = 0.0
        self._slip = np.zeros(2)
        self._rng = rng

    def command(self, velocity: Velocity) -> None:
        """Go for this velocity as soon as the command has reached the motors, as fast as they allow."""
        self._under_way.append((self._now + self.model.delay, velocity))

    def turn(self, dt: float) -> Velocity:
        """Let a step [s] pass; return the velocity that the wheels give the body in it."""
        model = self.model
        while self._under_way and self._under_way[0][0] <= self._now + 1e-9:
            self._target = self._under_way.popleft()[1]
        self._now += dt
        part = -math.expm1(-dt / model.lag) if model.lag > 0.0 else 1.0
        self.wheels = Velocity(
            _approach(self.wheels.linear, self._target.linear, model.acc_linear * dt, model.max_linear, part),
            _approach(self.wheels.angular, self._target.angular, model.acc_angular * dt, model.max_angular, part),
        )
        fade = math.exp(-dt / model.slip_time)
        most = np.array((model.slip_linear, model.slip_angular))
        self._slip = fade * self._slip + most * math.sqrt(1.0 - fade**2) * self._rng.standard_normal(2)
        linear, angular = self._slip.tolist()
        return Velocity(self.wheels.linear * (1.0 + linear), self.wheels.angular * (1.0 + angular))


def _approach(now: float, target: float, step: float, most: float, part: float) -> float:
    wanted = now + part * (min(max(target, -most), most) - now)
    return min(max(wanted, now - step), now + step)
