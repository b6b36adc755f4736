"""A Turtlebot 2 as a body in the simulated world: a disc on two wheels."""

import math
from dataclasses import dataclass

import numpy as np
import pymunk

from ppaas.controllers.base import Velocity
from ppaas.geometry import Pose2D, wrap_angle


@dataclass(frozen=True, slots=True)
class TurtlebotModel:
    """What a Turtlebot 2 (Kobuki base) is and can.

    Parameters
    ----------
    radius : float
        [m].
    mass : float
        [kg].
    max_linear, max_angular : float
        [m/s, rad/s]; the base does not turn faster than 180° a second, whatever it is told.
    acc_linear, acc_angular : float
        [m/s², rad/s²].
    slip : float
        Standard deviation of the part of a motion that the wheels lose or gain on the floor.
    slip_time : float
        Seconds for which the floor stays much the same under the wheels.
    """

    radius: float = 0.18
    mass: float = 6.3
    max_linear: float = 0.65
    max_angular: float = 3.0
    acc_linear: float = 1.0
    acc_angular: float = 4.0
    slip: float = 0.02
    slip_time: float = 1.0


class Turtlebot:
    """One Turtlebot.

    Parameters
    ----------
    space : pymunk.Space
        The world's.
    pose : Pose2D
        Where it stands at first, in the map frame.
    model : TurtlebotModel
        What it can.
    rng : numpy.random.Generator
        Its own, so that its fate does not depend on how many robots there are.
    """

    def __init__(self, space: pymunk.Space, pose: Pose2D, model: TurtlebotModel, rng: np.random.Generator) -> None:
        self.model = model
        self.wheels = Velocity()
        self.travelled = 0.0
        self._target = Velocity()
        self._slip = np.zeros(2)
        self._rng = rng
        self.body = pymunk.Body(model.mass, pymunk.moment_for_circle(model.mass, 0.0, model.radius))
        self.body.position = pose.x, pose.y
        self.body.angle = pose.theta
        self.body.velocity_func = self._turn_wheels
        self._last = self.body.position
        shape = pymunk.Circle(self.body, model.radius)
        shape.friction = 0.4
        space.add(self.body, shape)

    @property
    def pose(self) -> Pose2D:
        """The true pose in the map frame. For the sensors and the scorer; it is never published."""
        return Pose2D(self.body.position.x, self.body.position.y, wrap_angle(self.body.angle))

    def drive(self, velocity: Velocity) -> None:
        """Go for this velocity, as fast as the motors allow, from the next step on."""
        self._target = velocity

    def after_step(self) -> None:
        """Note how far the step has brought it."""
        position = self.body.position
        self.travelled += math.dist(position, self._last)
        self._last = position

    def _turn_wheels(self, body: pymunk.Body, _gravity: tuple[float, float], _damping: float, dt: float) -> None:
        """Set the velocity that the wheels give the body; the walls may take it away within the same step."""
        model = self.model
        self.wheels = Velocity(
            _approach(self.wheels.linear, self._target.linear, model.acc_linear * dt, model.max_linear),
            _approach(self.wheels.angular, self._target.angular, model.acc_angular * dt, model.max_angular),
        )
        fade = math.exp(-dt / model.slip_time)
        self._slip = fade * self._slip + model.slip * math.sqrt(1.0 - fade**2) * self._rng.standard_normal(2)
        speed = self.wheels.linear * (1.0 + self._slip[0])
        body.velocity = speed * math.cos(body.angle), speed * math.sin(body.angle)
        body.angular_velocity = self.wheels.angular * (1.0 + self._slip[1])


def _approach(now: float, target: float, step: float, most: float) -> float:
    bounded = min(max(target, -most), most)
    return min(max(bounded, now - step), now + step)
