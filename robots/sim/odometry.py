"""Simulated odometry of a Turtlebot: distance from wheel encoders and rotation from a gyro, both with errors."""

import math
from dataclasses import dataclass

import numpy as np

from ppaas.controllers.base import Velocity
from ppaas.errors import InvalidParameter
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance, Twist, TwistWithCovariance, Vector3
from ppaas.messages.nav_msgs import Odometry


@dataclass(frozen=True, slots=True)
class OdometryNoise:
    """Error model of the odometry; each value is a standard deviation.

    Parameters
    ----------
    scale, gyro_scale : float
        Scale error of the wheel diameter and of the gyro, as a fraction of the motion.
    gyro_bias : float
        Gyro bias [rad/s].
    gyro_walk : float
        Random walk of the bias [rad/s per √s].
    noise_linear, noise_angular : float
        Noise of a motion, per square root of its length [√m, √rad].
    drift : float
        Factor on all errors; 0 disables them.
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
            raise InvalidParameter(f"drift must be a number of 0 or more, not {self.drift}")


class WheelOdometry:
    """Integrates wheel and gyro measurements, starting at (0, 0, 0).

    Parameters
    ----------
    model : OdometryNoise
        Error model.
    rng : numpy.random.Generator
        Random generator of the errors.
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
        """Integrate one step.

        Parameters
        ----------
        wheel_speed : float
            Linear speed of the wheels, regardless of slip [m/s].
        turn_rate : float
            True angular velocity of the body [rad/s].
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
        # The velocity is smoothed as an encoder's is: the noise of one step divided by its length is not a speed.
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
