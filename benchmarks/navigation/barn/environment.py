"""Simulated BARN world with a Jackal: physics, sensors, and the ground truth for judging a run."""

import math

import numpy as np
import pymunk
from numpy.typing import NDArray

from benchmarks.navigation.barn.jackal import FOOTPRINT, LENGTH, MASS, WIDTH, Jackal
from benchmarks.navigation.barn.worlds import START, BarnWorld
from ppaas.controllers.base import Velocity
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.maps.grid import GridInfo
from ppaas.messages.geometry_msgs import Twist
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.sensor_msgs import LaserScan
from robots.sim.drivetrain import Drivetrain
from robots.sim.laser import Laser
from robots.sim.odometry import WheelOdometry

DT = 0.01
"""Time step [s]."""
ODOM, BASE_LINK = "odom", "base_link"


class Environment:
    """A Jackal among cylinders, with its own clock; equal seeds and commands give equal runs.

    Parameters
    ----------
    world : BarnWorld
    jackal : Jackal
        Models of the motors, the laser and the odometry.
    rng : numpy.random.Generator
        Source of all noise.
    start : Pose2D
        Start pose of the robot.
    """

    def __init__(self, world: BarnWorld, jackal: Jackal, rng: np.random.Generator, start: Pose2D = START) -> None:
        drive_rng, laser_rng, odometry_rng = rng.spawn(3)
        self._radius = world.radius
        self._centres = world.centres
        self._steps = 0
        self._drive = Drivetrain(jackal.drive, drive_rng)
        # The laser can hit only cylinders, so its grid of walls is one free cell.
        self._laser = Laser(np.zeros((1, 1), np.bool_), GridInfo(1.0, 1, 1), jackal.laser, laser_rng)
        self._odometry = WheelOdometry(jackal.odometry, odometry_rng)
        self._space = pymunk.Space()
        self._body = self._add_jackal(start)
        self._add_cylinders()

    def _add_jackal(self, start: Pose2D) -> pymunk.Body:
        body = pymunk.Body(MASS, pymunk.moment_for_box(MASS, (LENGTH, WIDTH)))
        body.position = start.x, start.y
        body.angle = start.theta
        body.velocity_func = self._turn_wheels
        self._space.add(body, pymunk.Poly(body, list(FOOTPRINT)))
        return body

    def _add_cylinders(self) -> None:
        ground = self._space.static_body
        self._space.add(*(pymunk.Circle(ground, self._radius, (x, y)) for x, y in self._centres.tolist()))

    def _turn_wheels(self, body: pymunk.Body, _gravity: tuple[float, float], _damping: float, dt: float) -> None:
        velocity = self._drive.turn(dt)
        body.velocity = velocity.linear * math.cos(body.angle), velocity.linear * math.sin(body.angle)
        body.angular_velocity = velocity.angular

    # -- interface of the robot ----------------------------------------------------------------------------------------

    def command(self, twist: Twist) -> None:
        """Execute a ``cmd_vel``."""
        self._drive.command(Velocity(twist.linear.x, twist.angular.z))

    def odometry(self) -> Odometry:
        """Return the current odometry."""
        return self._odometry.message(self.time, ODOM, BASE_LINK)

    def scan(self) -> LaserScan:
        """Return the current scan; the laser is in the centre of the base."""
        return self._laser.scan(self._laser.measure(self.pose, (self._centres, self._radius)), self.time, BASE_LINK)

    @property
    def time(self) -> float:
        """Time since the run began [s]."""
        return self._steps * DT

    def step(self) -> None:
        """Simulate one time step."""
        self._space.step(DT)
        self._steps += 1
        self._odometry.update(self._drive.wheels.linear, self._body.angular_velocity, DT)

    # -- ground truth --------------------------------------------------------------------------------------------------

    @property
    def pose(self) -> Pose2D:
        """The true pose in the frame of the world."""
        return Pose2D(self._body.position.x, self._body.position.y, wrap_angle(self._body.angle))

    def clearance(self) -> float:
        """Return the distance from the footprint to the nearest cylinder; negative if it touches one [m]."""
        return box_clearance(self.pose, LENGTH / 2, WIDTH / 2, self._centres, self._radius)


def box_clearance(
    pose: Pose2D, half_length: float, half_width: float, centres: NDArray[np.float64], radius: float
) -> float:
    """Return the distance from a box to the nearest disc [m]; negative where they overlap.

    Parameters
    ----------
    pose : Pose2D
        Centre of the box, and its heading.
    half_length, half_width : float
        Half of its size along and across its heading [m].
    centres : (m, 2) array
        Centres of the discs: x, y [m].
    radius : float
        Radius of all discs [m].
    """
    cosine, sine = math.cos(pose.theta), math.sin(pose.theta)
    right, up = (centres - (pose.x, pose.y)).T
    # Signed distances from the centre of each disc to the sides of the box, in the frame of the box.
    ahead = np.abs(cosine * right + sine * up) - half_length
    beside = np.abs(cosine * up - sine * right) - half_width
    outside = np.hypot(np.maximum(ahead, 0.0), np.maximum(beside, 0.0))
    inside = np.minimum(np.maximum(ahead, beside), 0.0)
    return float((outside + inside).min(initial=math.inf)) - radius
