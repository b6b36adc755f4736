"""Turtlebot 2 as a rigid body of the simulated world: a disc with a differential drive."""

import math
from dataclasses import dataclass

import numpy as np
import pymunk

from ppaas.controllers.base import Velocity
from ppaas.geometry import Pose2D, wrap_angle
from robots.sim.drivetrain import Drivetrain, DrivetrainModel


@dataclass(frozen=True, slots=True)
class TurtlebotModel:
    """Parameters of a Turtlebot 2 (Kobuki base).

    Parameters
    ----------
    radius : float
        Radius [m].
    mass : float
        Mass [kg].
    max_linear, max_angular : float
        Speed limits [m/s, rad/s]; the base turns at most 180° per second.
    acc_linear, acc_angular : float
        Acceleration limits [m/s², rad/s²].
    slip : float
        Standard deviation of the wheel slip, as a fraction of the motion.
    slip_time : float
        Correlation time of the slip [s].
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
        """Parameters of the drivetrain, without delay and lag."""
        return DrivetrainModel(
            self.max_linear, self.max_angular, self.acc_linear, self.acc_angular, self.slip, self.slip, self.slip_time
        )


class Turtlebot:
    """One Turtlebot.

    Parameters
    ----------
    space : pymunk.Space
        Space of the world.
    pose : Pose2D
        Pose at the start in the frame ``map``.
    model : TurtlebotModel
        Parameters.
    rng : numpy.random.Generator
        Random generator of this robot, so its noise does not depend on the number of robots.
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
        """True pose in the frame ``map``, for the sensors and the scorer; never published."""
        return Pose2D(self.body.position.x, self.body.position.y, wrap_angle(self.body.angle))

    @property
    def wheels(self) -> Velocity:
        """Velocity of the wheels."""
        return self._drive.wheels

    def drive(self, velocity: Velocity) -> None:
        """Set the target velocity from the next step on."""
        self._drive.command(velocity)

    def carry_to(self, pose: Pose2D) -> None:
        """Move the robot to another pose without its wheels or gyro measuring it (a kidnapping)."""
        self.body.position = self._last = pose.x, pose.y
        self.body.angle = pose.theta
        self._space.reindex_shapes_for_body(self.body)

    def after_step(self) -> None:
        """Add the motion of the step to the distance travelled."""
        position = self.body.position
        self.travelled += math.dist(position, self._last)
        self._last = position

    def _turn_wheels(self, body: pymunk.Body, _gravity: tuple[float, float], _damping: float, dt: float) -> None:
        """Set the velocity of the body from the wheels; contacts may still reduce it in the same step."""
        velocity = self._drive.turn(dt)
        body.velocity = velocity.linear * math.cos(body.angle), velocity.linear * math.sin(body.angle)
        body.angular_velocity = velocity.angular
