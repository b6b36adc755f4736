"""A simulated robot: body, base controller, odometry and laser. What it publishes comes from its sensors alone."""

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
import pymunk
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.messages.geometry_msgs import Twist
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.sensor_msgs import LaserScan
from robots.onboard.base_controller import BaseController, BaseLimits
from robots.sim.laser import Discs, Laser, LaserModel
from robots.sim.odometry import OdometryNoise, WheelOdometry
from robots.sim.turtlebot import Turtlebot, TurtlebotModel


@dataclass(frozen=True, slots=True)
class SimulatedRobotModel:
    """What a robot is made of."""

    base: TurtlebotModel = field(default_factory=TurtlebotModel)
    laser: LaserModel = field(default_factory=LaserModel)
    odometry: OdometryNoise = field(default_factory=OdometryNoise)
    odom_frame: str = "odom"
    base_frame: str = "base_link"
    command_timeout: float = 0.5


class RobotSurroundings(Protocol):
    """What a robot needs of the world that it stands in."""

    grid: GridMap
    occupied: NDArray[np.bool_]

    def time(self) -> float:
        """Return the seconds since the world began."""
        ...

    def stamp(self) -> float:
        """Return the present moment as a stamp."""
        ...

    def others(self, robot: "SimulatedRobot") -> tuple[Discs, ...]:
        """Return who else is there."""
        ...


class SimulatedRobot:
    """A robot of a simulated world, as its driver sees it.

    Parameters
    ----------
    world : RobotSurroundings
        Where it is.
    space : pymunk.Space
        Of the world.
    pose : Pose2D
        Where it stands at first.
    model : SimulatedRobotModel
        What it is made of.
    rng : numpy.random.Generator
        Its own.
    """

    def __init__(
        self,
        world: RobotSurroundings,
        space: pymunk.Space,
        pose: Pose2D,
        model: SimulatedRobotModel,
        rng: np.random.Generator,
    ) -> None:
        body_rng, laser_rng, odometry_rng = rng.spawn(3)
        limits = BaseLimits(model.base.max_linear, model.base.max_angular, model.command_timeout)
        self.model = model
        self.base = Turtlebot(space, pose, model.base, body_rng)
        self._world = world
        self._controller = BaseController(limits, world.time)
        self._laser = Laser(world.occupied, world.grid.info, model.laser, laser_rng)
        self._odometry = WheelOdometry(model.odometry, odometry_rng)

    def command(self, twist: Twist) -> None:
        """Take a ``cmd_vel``.

        Raises
        ------
        InvalidInput
            Not finite; the base stops.
        """
        self._controller.command(twist)

    def odometry(self) -> Odometry:
        """Return what the odometry tells now."""
        return self._odometry.message(self._world.stamp(), self.model.odom_frame, self.model.base_frame)

    def scan(self) -> LaserScan:
        """Return what the laser sees now; it stands in the middle of the base."""
        ranges = self._laser.measure(self.base.pose, *self._world.others(self))
        return self._laser.scan(ranges, self._world.stamp(), self.model.base_frame)

    def before_step(self) -> None:
        """Give the wheels their command."""
        self.base.drive(self._controller.velocity())

    def after_step(self, dt: float) -> None:
        """Let the odometry measure what the step has done."""
        self.base.after_step()
        self._odometry.update(self.base.wheels.linear, self.base.body.angular_velocity, dt)
