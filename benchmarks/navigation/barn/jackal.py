"""Clearpath Jackal of the BARN bench, with three levels of noise in sensors and motors."""

import math
from dataclasses import dataclass

from robots.sim.drivetrain import DrivetrainModel
from robots.sim.laser import LaserModel
from robots.sim.odometry import OdometryNoise

LENGTH, WIDTH = 0.508, 0.430
"""Size of a Jackal [m]."""
FOOTPRINT = (
    (LENGTH / 2, WIDTH / 2), (-LENGTH / 2, WIDTH / 2), (-LENGTH / 2, -WIDTH / 2), (LENGTH / 2, -WIDTH / 2),
)  # fmt: skip
MASS = 17.0
"""Mass of a Jackal [kg]."""
MAX_LINEAR, MAX_ANGULAR = 2.0, 4.0
"""Maximum velocities [m/s, rad/s]."""
BEAMS, FIELD_OF_VIEW, RANGE_MAX = 720, math.radians(270.0), 10.0
"""Number of laser beams, field of view [rad] and maximum range [m]."""


@dataclass(frozen=True, slots=True)
class Jackal:
    """Models of a Jackal's motors and sensors.

    Parameters
    ----------
    drive : DrivetrainModel
    laser : LaserModel
    odometry : OdometryNoise
    """

    drive: DrivetrainModel
    laser: LaserModel
    odometry: OdometryNoise


def _jackal(drive: DrivetrainModel, laser_sigma: float, scale: float, gyro_scale: float, gyro_bias: float) -> Jackal:
    laser = LaserModel(BEAMS, range_min=0.1, range_max=RANGE_MAX, sigma=laser_sigma, field_of_view=FIELD_OF_VIEW)
    # The only noise from step to step is the slip of the wheels, which odometry does not measure.
    odometry = OdometryNoise(
        scale=scale, gyro_scale=gyro_scale, gyro_bias=gyro_bias, gyro_walk=0.0, noise_linear=0.0, noise_angular=0.0
    )
    return Jackal(drive, laser, odometry)


NOISE = {
    "none": _jackal(DrivetrainModel(MAX_LINEAR, MAX_ANGULAR, 10.0, 20.0), 0.0, 0.0, 0.0, 0.0),
    "nominal": _jackal(
        DrivetrainModel(MAX_LINEAR, MAX_ANGULAR, 10.0, 20.0, slip_linear=0.01, slip_angular=0.03, lag=0.05, delay=0.05),
        0.01, 0.01, 0.01, 0.002,
    ),
    "hard": _jackal(
        DrivetrainModel(MAX_LINEAR, MAX_ANGULAR, 3.0, 6.0, slip_linear=0.05, slip_angular=0.15, lag=0.08, delay=0.10),
        0.02, 0.02, 0.03, 0.001,
    ),
}  # fmt: skip
"""Robots by noise level: standard deviations of the laser [m], of the scales of wheels and gyro, and of its bias
[rad/s]."""
