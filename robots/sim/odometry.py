"""Odometry as a Turtlebot has it: distance from the wheels, turning from the gyro, and both a little wrong."""

import math
from dataclasses import dataclass

import numpy as np

from ppaas.controllers.base import Velocity
from ppaas.errors import InvalidParameter
from ppaas.geometry import Pose2D
from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance, Twist, TwistWithCovariance, Vector3
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.std_msgs import Header, Time


@dataclass(frozen=True, slots=True)
class OdometryNoise:
    """How wrong it is; each number is a standard deviation.

    Parameters
    ----------
    scale, gyro_scale : float
        Error of the wheels' diameter, and of the gyro's scale, as a part of the motion.
    gyro_bias : float
        What the gyro tells when nothing turns [rad/s].
    gyro_walk : float
        How the bias wanders [rad/s in one √s].
    noise_linear, noise_angular : float
        Of a motion, as a part of the square root of its length [√m, √rad].
    drift : float
        Factor on all of these: 0 is odometry without a fault of its own.
    """

    scale: float = 0.01
    gyro_scale: float = 0.01
    gyro_bias: float = 0.0005
    gyro_walk: float = 0.00005
    noise_linear: float = 0.005
    noise_angular: float = 0.01
    drift: float = 1.0

    def __post_init__(self) -> None:
        if not (math.isfinite(self.drift) and self.drift >= 0.0):
            raise InvalidParameter(f"drift must be a number from 0 up, not {self.drift}")


class WheelOdometry:
    """Adds up what wheels and gyro measure, from (0, 0, 0) where the robot was switched on.

    Parameters
    ----------
    model : OdometryNoise
        How wrong it is.
    rng : numpy.random.Generator
        Decides how this robot's sensors are wrong.
    """

    def __init__(self, model: OdometryNoise, rng: np.random.Generator) -> None:
        self.pose = Pose2D(0.0, 0.0, 0.0)
        self.velocity = Velocity()
        self._model = model
        self._rng = rng
        scales = np.array((model.scale, model.gyro_scale))
        self._wheel_scale, self._gyro_scale = 1.0 + model.drift * scales * rng.standard_normal(2)
        self._bias = model.drift * model.gyro_bias * rng.standard_normal()

    def update(self, wheel_speed: float, turn_rate: float, dt: float) -> None:
        """Take one step.

        Parameters
        ----------
        wheel_speed : float
            How fast the wheels roll forwards, slip or not [m/s].
        turn_rate : float
            How fast the body really turns [rad/s].
        dt : float
            Length of the step [s].
        """
        model, rng = self._model, self._rng
        self._bias += model.drift * model.gyro_walk * math.sqrt(dt) * rng.standard_normal()
        moved, turned = wheel_speed * dt, turn_rate * dt
        noise_linear = model.drift * model.noise_linear * math.sqrt(abs(moved)) * rng.standard_normal()
        noise_angular = model.drift * model.noise_angular * math.sqrt(abs(turned)) * rng.standard_normal()
        distance = moved * self._wheel_scale + noise_linear
        angle = turned * self._gyro_scale + self._bias * dt + noise_angular
        half_turned = self.pose @ Pose2D(0.0, 0.0, angle / 2.0)
        self.pose = half_turned @ Pose2D(distance, 0.0, angle / 2.0)
        # What is told as velocity is smoothed as an encoder's is: the noise of one step over a step is no speed.
        self.velocity = Velocity(wheel_speed * self._wheel_scale, turn_rate * self._gyro_scale + self._bias)

    def message(self, stamp: float, frame_id: str, child_frame_id: str) -> Odometry:
        """Return ``nav_msgs/Odometry``."""
        twist = Twist(Vector3(x=float(self.velocity.linear)), Vector3(z=float(self.velocity.angular)))
        return Odometry(
            header=Header(stamp=Time.of(stamp), frame_id=frame_id),
            child_frame_id=child_frame_id,
            pose=PoseWithCovariance(Pose.of(Pose2D(*map(float, self.pose)))),
            twist=TwistWithCovariance(twist),
        )
