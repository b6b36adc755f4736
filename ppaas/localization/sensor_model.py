"""Sensor models: how well a scan fits the map as seen from each particle, by its beams or by a likelihood field.

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
from ppaas.localization.beams import choose_beams, choose_rays, scan_points, spread, thinned
from ppaas.localization.kernels import beam_model, likelihood_field
from ppaas.localization.kernels.sight import stopped_short
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


# -- beam model (*Probabilistic Robotics*, 6.3): each range against the range cast in the map --------------------------


class BeamModel(SensorModel):
    """Sensor model ``beam``, several times as slow as a likelihood field."""

    def __init__(self, layers: MapLayers, parameters: AmclParameters, threads: Threads) -> None:
        super().__init__(layers, parameters, threads)
        p = parameters
        self._shares = beam_model.BeamShares(
            p.laser_z_hit, p.laser_z_short, p.laser_z_max, p.laser_z_rand, p.laser_sigma_hit, p.laser_lambda_short
        )

    def _choose(self, scan: LaserScan, laser: Pose2D) -> NDArray[np.float64]:
        return choose_rays(scan, laser, self._parameters.laser_max_beams)

    def points(self, beams: NDArray[np.float64], range_max: float) -> NDArray[np.float64]:
        """Return the end points of the beams that are shorter than ``range_max``."""
        x, y, angle, length = beams[beams[:, 3] < range_max].T
        return np.column_stack((x + length * np.cos(angle), y + length * np.sin(angle)))

    def _sums(
        self, particles: NDArray[np.float64], beams: NDArray[np.float64], range_max: float, *, parallel: bool
    ) -> NDArray[np.float64]:
        score = beam_model.score_parallel if parallel else beam_model.score_serial
        return score(particles, beams, self._distance, self._resolution, self._origin, self._shares, range_max)


# -- beams that end at people: distance filter (Fox, Burgard, Thrun, 1999) ---------------------------------------------

NEAR, BEYOND = 2.0, 0.2
"""A beam ends at a person if it is shorter than `NEAR` and at least `BEYOND` shorter than in the map [m]."""

MANY = 0.25
"""Part of the beams above which the robot is taken to be in a crowd. A pose that is slightly off explains fewer."""


def ends_at_people(pose: Pose2D, points: NDArray[np.float64], layers: MapLayers) -> NDArray[np.bool_]:
    """Return a mask of the beams that end at people of a crowd; all False without a crowd.

    Parameters
    ----------
    pose : Pose2D
        Approximate pose of the robot in the map frame.
    points : (n, 2) array
        End points of beams in the robot's frame [m].
    layers : MapLayers
        The map; its ``distance`` is read.

    Returns
    -------
    (n,) bool array
    """
    people = np.zeros(len(points), dtype=np.bool_)
    near = points[:, 0] ** 2 + points[:, 1] ** 2 < NEAR**2
    if np.count_nonzero(near) > MANY * len(points):
        info = layers.grid.info
        origin = np.array(info.origin)
        short = stopped_short(np.array(pose), points[near], layers.distance, info.resolution, origin, BEYOND)
        if np.count_nonzero(short) > MANY * len(points):
            people[near] = short
    return people


# -- likelihood fields (*Probabilistic Robotics*, 6.4): the distance from a beam's end to an obstacle ------------------

_LEAST = 1e-300
"""Smallest likelihood, so that its logarithm is finite."""


class LikelihoodField(SensorModel):
    """Sensor model ``likelihood_field``, which sums up the cubes of the beams' likelihoods."""

    def __init__(self, layers: MapLayers, parameters: AmclParameters, threads: Threads) -> None:
        super().__init__(layers, parameters, threads)
        self._layers = layers
        self._table: tuple[float, NDArray[np.int64]] | None = None

    def beams_and_hits(
        self, scan: LaserScan, laser: Pose2D, most: int
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the results of `beams` and of `hits`, which are chosen from the same points."""
        points = thinned(scan_points(self._limited(scan), laser))
        return spread(points, self._parameters.laser_max_beams), spread(points, most)

    def informative(self, beams: NDArray[np.float64], pose: Pose2D) -> NDArray[np.float64]:
        """Return the beams that do not end at people who crowd around the robot."""
        return beams[~ends_at_people(pose, beams, self._layers)]

    def _choose(self, scan: LaserScan, laser: Pose2D) -> NDArray[np.float64]:
        return choose_beams(scan_points(scan, laser), self._parameters.laser_max_beams)

    def _sums(
        self, particles: NDArray[np.float64], beams: NDArray[np.float64], range_max: float, *, parallel: bool
    ) -> NDArray[np.float64]:
        score = likelihood_field.score_parallel if parallel else likelihood_field.score_serial
        table = self._table_for(range_max)
        return score(particles, beams, self._distance, self._resolution, self._origin, table)

    def _table_for(self, range_max: float) -> NDArray[np.int64]:
        if self._table is None or self._table[0] != range_max:
            p = self._parameters
            likelihoods = likelihood_field.likelihoods(
                self._resolution,
                p.laser_z_hit,
                p.laser_z_rand / range_max,
                p.laser_sigma_hit,
                p.laser_likelihood_max_dist,
            )
            terms = np.rint(self._terms(likelihoods) * likelihood_field.ONE).astype(np.int64)
            self._table = range_max, terms
        return self._table[1]

    def _terms(self, likelihoods: NDArray[np.float64]) -> NDArray[np.float64]:
        return likelihoods**3


class LikelihoodFieldProb(LikelihoodField):
    """Sensor model ``likelihood_field_prob``, which multiplies the likelihoods as if beams were independent."""

    def _terms(self, likelihoods: NDArray[np.float64]) -> NDArray[np.float64]:
        logarithms: NDArray[np.float64] = np.log(np.maximum(likelihoods, _LEAST))
        return logarithms

    def _fit(self, sums: NDArray[np.float64], beams: int) -> Fit:
        return Fit(np.exp(sums - sums.max()), np.exp(sums / beams))


# -- choice by name ----------------------------------------------------------------------------------------------------

_FIELDS: dict[str, type[SensorModel]] = {
    "likelihood_field": LikelihoodField,
    "likelihood_field_prob": LikelihoodFieldProb,
}


def sensor_model(layers: MapLayers, parameters: AmclParameters, threads: Threads) -> SensorModel:
    """Return the sensor model named by ``laser_model_type``."""
    kind = _FIELDS.get(parameters.laser_model_type)
    if kind is None:
        # Rarely used: imported only here, so that not every container loads its kernels.
        from ppaas.localization.sensor_model import BeamModel  # noqa: PLC0415

        kind = BeamModel
    return kind(layers, parameters, threads)
