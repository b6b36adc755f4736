"""Simulated robot: body, base controller, odometry, laser and depth camera. It publishes only sensor output."""

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
import pymunk
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.messages.geometry_msgs import Twist
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.sensor_msgs import CameraInfo, Image, LaserScan
from robots.onboard.base_controller import BaseController, BaseLimits
from robots.sim.depth.camera import DepthCamera, DepthCameraModel, DepthImage, Scene
from robots.sim.laser import Discs, Laser, LaserModel
from robots.sim.odometry import OdometryNoise, WheelOdometry
from robots.sim.turtlebot import Turtlebot, TurtlebotModel


@dataclass(frozen=True, slots=True)
class SimulatedRobotModel:
    """Models of a robot's parts, its frames, and the time-out of its commands [s]. It has no camera by default."""

    base: TurtlebotModel = field(default_factory=TurtlebotModel)
    laser: LaserModel = field(default_factory=LaserModel)
    odometry: OdometryNoise = field(default_factory=OdometryNoise)
    camera: DepthCameraModel | None = None
    odom_frame: str = "odom"
    base_frame: str = "base_link"
    command_timeout: float = 0.5


class RobotSurroundings(Protocol):
    """Interface of the world to a robot."""

    grid: GridMap
    occupied: NDArray[np.bool_]

    def time(self) -> float:
        """Return the simulated time [s]."""
        ...

    def stamp(self) -> float:
        """Return the stamp of the current time [seconds since the epoch]."""
        ...

    def others(self, robot: "SimulatedRobot") -> tuple[Discs, ...]:
        """Return the other robots, the people and the furniture at the height of lasers, as discs."""
        ...

    def scene(self, robot: "SimulatedRobot") -> Scene:
        """Return the other robots, the people and the furniture, as depth cameras see them."""
        ...


class SimulatedRobot:
    """Robot of a simulated world.

    Parameters
    ----------
    world : RobotSurroundings
        World that contains the robot.
    space : pymunk.Space
        Space of the world.
    pose : Pose2D
        Pose at the start.
    model : SimulatedRobotModel
        Models of its parts.
    rng : numpy.random.Generator
        Random generator of this robot.
    """

    def __init__(
        self,
        world: RobotSurroundings,
        space: pymunk.Space,
        pose: Pose2D,
        model: SimulatedRobotModel,
        rng: np.random.Generator,
    ) -> None:
        body_rng, laser_rng, odometry_rng, camera_rng = rng.spawn(4)
        limits = BaseLimits(model.base.max_linear, model.base.max_angular, model.command_timeout)
        self.model = model
        self.base = Turtlebot(space, pose, model.base, body_rng)
        self._world = world
        self._controller = BaseController(limits, world.time)
        self._laser = Laser(world.occupied, world.grid.info, model.laser, laser_rng)
        self._odometry = WheelOdometry(model.odometry, odometry_rng)
        self._camera: DepthCamera | None = None
        if model.camera is not None:
            self._camera = DepthCamera(world.occupied, world.grid.info, model.camera, camera_rng)

    def command(self, twist: Twist) -> None:
        """Execute a ``cmd_vel``.

        Raises
        ------
        InvalidInput
            The command is not finite; the base stops.
        """
        self._controller.command(twist)

    def odometry(self) -> Odometry:
        """Return the current odometry."""
        return self._odometry.message(self._world.stamp(), self.model.odom_frame, self.model.base_frame)

    def scan(self) -> LaserScan:
        """Return the current scan; the laser is in the centre of the base."""
        ranges = self._laser.measure(self.base.pose, *self._world.others(self))
        return self._laser.scan(ranges, self._world.stamp(), self.model.base_frame)

    @property
    def camera(self) -> DepthCamera:
        """The depth camera.

        Raises
        ------
        InvalidInput
            The robot has none.
        """
        if self._camera is None:
            raise InvalidInput("the robot has no depth camera: give its model a 'camera'")
        return self._camera

    def depths(self) -> DepthImage:
        """Return the current depths, (height, width) uint16 [mm]; 0 without a reading."""
        return self.camera.measure(self.base.pose, self._world.scene(self))

    def depth_image(self) -> Image:
        """Return the current depth image, 16UC1."""
        return self.camera.image(self.depths(), self._world.stamp())

    def camera_info(self) -> CameraInfo:
        """Return the parameters of the depth camera."""
        return self.camera.info(self._world.stamp())

    def before_step(self) -> None:
        """Pass the current command to the wheels."""
        self.base.drive(self._controller.velocity())

    def after_step(self, dt: float) -> None:
        """Update the odometry after a step of ``dt`` [s]."""
        self.base.after_step()
        self._odometry.update(self.base.wheels.linear, self.base.body.angular_velocity, dt)
