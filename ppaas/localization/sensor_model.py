"""Interface of sensor models: how well a scan fits the map as seen from each particle.

*Probabilistic Robotics*, chapter 6, as in amcl (``amcl_laser.cpp``). The beams of a scan are not independent: instead
of multiplying their likelihoods, ``likelihood_field`` and ``beam`` sum up the cubes.
"""

from abc import ABC, abstractmethod
from typing import NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.map_layers import MapLayers
from ppaas.geometry import Pose2D
from ppaas.kernel_threads import limit_threads
from ppaas.localization.beams import choose_beams, scan_points
from ppaas.localization.parameters import AmclParameters
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.thread_budget import Threads

PARALLEL_FROM = 1 << 18
"""Particles times beams below which one thread is used: on busy cores, waiting for threads costs more."""


class Fit(NamedTuple):
    """Fit of a scan from the pose of each particle.

    Parameters
    ----------
    weights : (n,) array
        Factors of the particles' weights.
    fits : (n,) array
        Mean fit of a beam, comparable between scans with different numbers of beams.
    """

    weights: NDArray[np.float64]
    fits: NDArray[np.float64]


class SensorModel(ABC):
    """Model of the laser on one map.

    Parameters
    ----------
    layers : MapLayers
        The map; its ``distance`` is read.
    parameters : AmclParameters
    threads : callable
        Returns the largest number of threads that kernels may use now; it does not affect the result.
    """

    def __init__(self, layers: MapLayers, parameters: AmclParameters, threads: Threads) -> None:
        info = layers.grid.info
        self._distance, self._resolution, self._origin = layers.distance, info.resolution, np.array(info.origin)
        self._parameters = parameters
        self._threads = threads

    def beams(self, scan: LaserScan, laser: Pose2D) -> NDArray[np.float64]:
        """Return the beams of a scan to compare with the map, one per row, in the robot's frame.

        Raises
        ------
        InvalidInput
            The angles or limits are not finite, or there are too many ranges.
        """
        return self._choose(self._limited(scan), laser)

    def hits(self, scan: LaserScan, laser: Pose2D, most: int) -> NDArray[np.float64]:
        """Return at most ``most`` end points of beams that hit something, in the robot's frame: (n, 2) [m].

        Raises
        ------
        InvalidInput
            As `beams`.
        """
        return choose_beams(scan_points(self._limited(scan), laser), most)

    def beams_and_hits(
        self, scan: LaserScan, laser: Pose2D, most: int
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the results of `beams` and of `hits`."""
        return self.beams(scan, laser), self.hits(scan, laser, most)

    def _limited(self, scan: LaserScan) -> LaserScan:
        return msgspec.structs.replace(scan, range_min=self._range_min(scan), range_max=self.range_max(scan))

    def points(self, beams: NDArray[np.float64], range_max: float) -> NDArray[np.float64]:
        """Return the end points of beams that hit something: (n, 2), in the robot's frame [m].

        Parameters
        ----------
        beams : (m, k) array
            Result of `beams`.
        range_max : float
            Result of `range_max` [m].
        """
        return beams

    def informative(self, beams: NDArray[np.float64], pose: Pose2D) -> NDArray[np.float64]:
        """Return the beams that show where a robot near ``pose`` is; all of them if the model itself includes people.

        Parameters
        ----------
        beams : (m, k) array
            Result of `beams`.
        pose : Pose2D
            In the map frame.
        """
        return beams

    def range_max(self, scan: LaserScan) -> float:
        """Return the range from which on a beam has hit nothing [m]."""
        most = self._parameters.laser_max_range
        return scan.range_max if most < 0.0 else min(scan.range_max, most)

    def _range_min(self, scan: LaserScan) -> float:
        return max(scan.range_min, self._parameters.laser_min_range)

    def fit(self, particles: NDArray[np.float64], beams: NDArray[np.float64], range_max: float) -> Fit:
        """Return the fit of a scan from each particle.

        Parameters
        ----------
        particles : (n, 3) array
            x, y [m], theta [rad] in the map frame.
        beams : (m, k) array
            Result of `beams`; at least one row.
        range_max : float
            Result of `range_max` [m].
        """
        wanted = self._threads() if len(particles) * len(beams) >= PARALLEL_FROM else 1
        with limit_threads(wanted) as threads:
            sums = self._sums(particles, beams, range_max, parallel=threads > 1)
        return self._fit(sums, len(beams))

    def _fit(self, sums: NDArray[np.float64], beams: int) -> Fit:
        return Fit(1.0 + sums, sums / beams)

    @abstractmethod
    def _choose(self, scan: LaserScan, laser: Pose2D) -> NDArray[np.float64]: ...

    @abstractmethod
    def _sums(
        self, particles: NDArray[np.float64], beams: NDArray[np.float64], range_max: float, *, parallel: bool
    ) -> NDArray[np.float64]: ...
