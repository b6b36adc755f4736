"""Parameters of 3D mapping, named as in ROS's ``octomap_server``."""

import math
from typing import NamedTuple

import msgspec
import numpy as np

from ppaas.errors import InvalidParameter
from ppaas.parameters import Parameters, check_numbers


class SensorLogOdds(NamedTuple):
    """Log-odds of the sensor, in float32 as in OctoMap: of a hit and a miss, and the limits of a voxel."""

    hit: np.float32
    miss: np.float32
    least: np.float32
    most: np.float32


class VolumeParameters(Parameters, frozen=True):
    """Parameters of a voxel volume, with the names and defaults of ``octomap_server`` (ROS 2).

    Parameters
    ----------
    resolution : float
        Edge of a voxel [m].
    sensor_model.max_range : float
        Longer rays are cut here and end at no obstacle [m]; −1 for no limit.
    sensor_model.hit, sensor_model.miss : float
        Probabilities that a voxel is occupied if a ray ends in it and if one passes it.
    sensor_model.min, sensor_model.max : float
        Limits of the probability of a voxel (clamping).
    point_cloud_min_z, point_cloud_max_z : float
        Points below or above are ignored [m].
    occupancy_min_z, occupancy_max_z : float
        Heights between which voxels count in the projected map [m].
    min_x_size, min_y_size : float
        Least size of the projected map, around the origin of the map frame [m].
    filter_speckles : bool
        Whether an occupied voxel without an occupied neighbour is left out of the projected map.
    max_blocks : int
        Largest number of blocks of 8 × 8 × 8 voxels, of 2 KiB each, including the blocks of submaps.
    """

    resolution: float = 0.05
    max_range: float = msgspec.field(default=-1.0, name="sensor_model.max_range")
    hit: float = msgspec.field(default=0.7, name="sensor_model.hit")
    miss: float = msgspec.field(default=0.4, name="sensor_model.miss")
    min: float = msgspec.field(default=0.12, name="sensor_model.min")
    max: float = msgspec.field(default=0.97, name="sensor_model.max")
    point_cloud_min_z: float = -100.0
    point_cloud_max_z: float = 100.0
    occupancy_min_z: float = -100.0
    occupancy_max_z: float = 100.0
    min_x_size: float = 0.0
    min_y_size: float = 0.0
    filter_speckles: bool = False
    max_blocks: int = 1 << 18

    def __post_init__(self) -> None:
        """Check the ranges."""
        check_numbers(self, positive=("resolution", "max_blocks"), signed=_SIGNED)
        if self.max_range <= 0.0 and self.max_range != -1.0:
            raise InvalidParameter(f"sensor_model.max_range must be above 0, or -1 for none, not {self.max_range}")
        if not 0.0 < self.min < 0.5 < self.max < 1.0:
            raise InvalidParameter(
                f"sensor_model.min must be between 0 and 0.5, and sensor_model.max between 0.5 and 1, not {self.min} "
                f"and {self.max}"
            )
        if not (0.5 <= self.hit < 1.0 and 0.0 < self.miss <= 0.5):
            raise InvalidParameter(
                "sensor_model.hit must be at least 0.5 and below 1, and sensor_model.miss above 0 and at most 0.5, "
                f"not {self.hit} and {self.miss}"
            )

    def model(self) -> SensorLogOdds:
        """Return the log-odds of the sensor."""
        return SensorLogOdds(*(np.float32(math.log(p / (1.0 - p))) for p in (self.hit, self.miss, self.min, self.max)))


_SIGNED = ("max_range", "point_cloud_min_z", "point_cloud_max_z", "occupancy_min_z", "occupancy_max_z")
