"""Simulated laser scanner: measures walls, other robots and people."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo
from ppaas.maps.raycast import cast_rays
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.sensor_msgs import LaserScan
from robots.sim.kernels import discs as kernels

Discs = tuple[NDArray[np.float64], float]
"""Discs of one size: (m, 2) centres and their radius [m]."""


@dataclass(frozen=True, slots=True)
class LaserModel:
    """Parameters of a laser scanner.

    Parameters
    ----------
    beams : int
        Number of beams, evenly spaced over the field of view, from right to left. With a full circle, the first
        beam points backwards.
    range_min, range_max : float
        Limits of the range [m].
    sigma : float
        Standard deviation of a range [m].
    field_of_view : float
        Field of view, centred on the robot's heading [rad].
    """

    beams: int = 360
    range_min: float = 0.12
    range_max: float = 8.0
    sigma: float = 0.01
    field_of_view: float = 2.0 * math.pi

    @property
    def increment(self) -> float:
        """Angle between two beams [rad]."""
        whole_circle = self.field_of_view >= 2.0 * math.pi
        return self.field_of_view / (self.beams if whole_circle else self.beams - 1)

    @property
    def angles(self) -> NDArray[np.float64]:
        """(beams,) angles of the beams relative to the robot's heading [rad]."""
        return np.asarray(-0.5 * self.field_of_view + self.increment * np.arange(self.beams))


def cast_at_discs(
    origin: Pose2D, angles: NDArray[np.float64], centres: NDArray[np.float64], radius: float
) -> NDArray[np.float64]:
    """Return the distance from a pose to the nearest disc along each ray.

    Parameters
    ----------
    origin : Pose2D
        Origin of the rays, outside all discs; the angles are relative to its heading.
    angles : (n,) array
        Directions of the rays [rad].
    centres : (m, 2) array
        Centres of the discs: x, y [m].
    radius : float
        Radius of the discs [m].

    Returns
    -------
    (n,) array
        Distances [m]; infinite where no disc is hit.
    """
    ranges: NDArray[np.float64] = kernels.cast_at_discs(
        origin.x, origin.y, np.ascontiguousarray(angles + origin.theta), np.ascontiguousarray(centres), radius
    )
    return ranges


class Laser:
    """Laser scanner in the centre of its robot.

    Parameters
    ----------
    occupied : (height, width) bool array
        Occupied cells of the map.
    info : GridInfo
        Resolution and origin of the map.
    model : LaserModel
        Parameters.
    rng : numpy.random.Generator
        Random generator of the noise.
    """

    def __init__(
        self, occupied: NDArray[np.bool_], info: GridInfo, model: LaserModel, rng: np.random.Generator
    ) -> None:
        self.model = model
        self._occupied = occupied
        self._info = info
        self._angles = model.angles
        self._rng = rng

    def look_at(self, occupied: NDArray[np.bool_], info: GridInfo) -> None:
        """Measure another map from now on."""
        self._occupied, self._info = occupied, info

    def measure(self, pose: Pose2D, *others: Discs) -> NDArray[np.float64]:
        """Return the (beams,) measured ranges [m], infinite where nothing is in range.

        Parameters
        ----------
        pose : Pose2D
            True pose of the scanner in the map frame.
        *others : (centres, radius)
            Other robots and people, grouped by radius.
        """
        model = self.model
        ranges = cast_rays(self._occupied, self._info, pose, self._angles, model.range_max)
        for centres, radius in others:
            ranges = np.minimum(ranges, cast_at_discs(pose, self._angles, centres, radius))
        noisy = np.maximum(ranges + model.sigma * self._rng.standard_normal(model.beams), 0.0)
        return np.where(noisy <= model.range_max, noisy, np.inf)

    def scan(self, ranges: NDArray[np.float64], stamp: float, frame_id: str) -> LaserScan:
        """Return the ranges as ``sensor_msgs/LaserScan``, rounded to millimetres."""
        millimetres = np.round(ranges, 3).tolist()
        return LaserScan(
            header=Header(stamp=Time.of(stamp), frame_id=frame_id),
            angle_min=float(self._angles[0]),
            angle_max=float(self._angles[-1]),
            angle_increment=self.model.increment,
            range_min=self.model.range_min,
            range_max=self.model.range_max,
            ranges=[value if value < math.inf else None for value in millimetres],
        )
