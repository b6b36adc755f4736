"""Simulated Turtlebot: body, base controller, odometry, laser and depth camera. It publishes only sensor output."""

import math
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
import pymunk
from numpy.typing import NDArray

from ppaas.controllers.base import Velocity
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.maps.grid import GridMap
from ppaas.messages.geometry_msgs import Twist
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.sensor_msgs import CameraInfo, Image, LaserScan
from robots.onboard.base_controller import BaseController, BaseLimits
from robots.sim.depth.camera import DepthCamera, DepthCameraModel, DepthImage, Scene
from robots.sim.drivetrain import Drivetrain, DrivetrainModel
from robots.sim.laser import Discs, Laser, LaserModel
from robots.sim.odometry import OdometryNoise, WheelOdometry


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
        self._shape = pymunk.Circle(self.body, model.radius)
        self._shape.friction = 0.4
        space.add(self.body, self._shape)

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

    def enter(self, space: pymunk.Space, pose: Pose2D) -> None:
        """Continue in another space, at a pose there, without its wheels or gyro measuring it."""
        self._space.remove(self.body, self._shape)
        self._space = space
        space.add(self.body, self._shape)
        self.carry_to(pose)

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

    def enter(self, world: RobotSurroundings, space: pymunk.Space, pose: Pose2D) -> None:
        """Continue in another world, at a pose there, without its wheels or gyro measuring it.

        Both worlds have one time, by which commands expire.
        """
        self._world = world
        self._laser.look_at(world.occupied, world.grid.info)
        if self._camera is not None:
            self._camera.look_at(world.occupied, world.grid.info)
        self.base.enter(space, pose)

    def before_step(self) -> None:
        """Pass the current command to the wheels."""
        self.base.drive(self._controller.velocity())

    def after_step(self, dt: float) -> None:
        """Update the odometry after a step of ``dt`` [s]."""
        self.base.after_step()
        self._odometry.update(self.base.wheels.linear, self.base.body.angular_velocity, dt)
