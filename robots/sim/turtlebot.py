"""A Turtlebot 2 as a body in the simulated world: a disc on two wheels."""

import math
from dataclasses import dataclass

import numpy as np
import pymunk

from ppaas.controllers.base import Velocity
from ppaas.geometry import Pose2D, wrap_angle
from robots.sim.drivetrain import Drivetrain, DrivetrainModel


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

    @property
    def drive(self) -> DrivetrainModel:
        """What its motors and wheels can; they follow a command at once."""
        return DrivetrainModel(
            self.max_linear, self.max_angular, self.acc_linear, self.acc_angular, self.slip, self.slip, self.slip_time
        )


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
        self.travelled = 0.0
        self._space = space
        self._drive = Drivetrain(model.drive, rng)
        self.body = pymunk.Body(model.mass, pymunk.moment_for_circle(model.mass, 0.0, model.radius))
        self.body.position = pose.x, pose.y
        self.body.angle = pose.theta
        self.body.velocity_func = self._turn_wheels
        self._last: tuple[float, float] = self.body.position
        shape = pymunk.Circle(self.body, model.radius)
        shape.friction = 0.4
        space.add(self.body, shape)

    @property
    def pose(self) -> Pose2D:
        """The true pose in the map frame. For the sensors and the scorer; it is never published."""
        return Pose2D(self.body.position.x, self.body.position.y, wrap_angle(self.body.angle))

    @property
    def wheels(self) -> Velocity:
        """How fast the wheels roll."""
        return self._drive.wheels

    def drive(self, velocity: Velocity) -> None:
        """Go for this velocity, as fast as the motors allow, from the next step on."""
        self._drive.command(velocity)

    def carry_to(self, pose: Pose2D) -> None:
        """Put it elsewhere, which neither its wheels nor its gyro notice."""
        self.body.position = self._last = pose.x, pose.y
        self.body.angle = pose.theta
        self._space.reindex_shapes_for_body(self.body)

    def after_step(self) -> None:
        """Note how far the step has brought it."""
        position = self.body.position
        self.travelled += math.dist(position, self._last)
        self._last = position

    def _turn_wheels(self, body: pymunk.Body, _gravity: tuple[float, float], _damping: float, dt: float) -> None:
        """Set the velocity that the wheels give the body; the walls may take it away within the same step."""
        velocity = self._drive.turn(dt)
        body.velocity = velocity.linear * math.cos(body.angle), velocity.linear * math.sin(body.angle)
        body.angular_velocity = velocity.angular
