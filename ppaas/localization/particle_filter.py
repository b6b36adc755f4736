"""Monte Carlo localization in a likelihood field, with the adaptive number of particles that gives AMCL its name.

Thrun, Burgard, Fox, *Probabilistic Robotics* (2005), tables 5.6, 6.3 and 8.4; names and defaults are amcl's. A robot
says where it starts, so there is no global localization here: no random particles are injected.
"""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.localization.estimate import PoseEstimate, bins_of, estimate
from ppaas.localization.kernels.likelihood_field import likelihoods, score_scan
from ppaas.localization.kernels.motion import sample_motion
from ppaas.localization.kernels.resample import draw_low_variance
from ppaas.localization.parameters import AmclParameters
from ppaas.maps.layers import MapLayers

_TURN_IN_PLACE = 0.01
"""Below this distance [m] a motion has no direction worth speaking of (``amcl_odom.cpp``)."""


class ParticleFilter:
    """Tracks a robot in a map.

    Parameters
    ----------
    layers : MapLayers
        The map; its ``distance`` is read.
    parameters : AmclParameters
        The same seed and the same input give the same particles.
    """

    def __init__(self, layers: MapLayers, parameters: AmclParameters) -> None:
        self._distance = layers.distance
        info = layers.grid.info
        self._resolution = info.resolution
        self._origin = np.array(info.origin)
        self._parameters = parameters
        self._random = np.random.default_rng(parameters.seed)
        self._odom: Pose2D | None = None
        self._updates = 0
        self._likelihood: tuple[float, NDArray[np.float64]] | None = None
        p = parameters
        self._alphas = np.array((p.odom_alpha1, p.odom_alpha2, p.odom_alpha3, p.odom_alpha4))
        self.initialise(Pose2D(0.0, 0.0), np.zeros((3, 3)))

    def initialise(self, pose: Pose2D, covariance: NDArray[np.float64]) -> None:
        """Start anew around a pose.

        Parameters
        ----------
        pose : Pose2D
            In the map frame.
        covariance : (3, 3) array
            Of x [m], y [m], theta [rad].

        Raises
        ------
        InvalidInput
            Not finite, or no covariance.
        """
        if not (pose.is_finite() and np.isfinite(covariance).all()):
            raise InvalidInput("an initial pose and its covariance must be finite")
        values, vectors = np.linalg.eigh((covariance + covariance.T) / 2.0)
        if values.min() < -1e-9:
            raise InvalidInput("the covariance of an initial pose must not be negative")
        spread = vectors * np.sqrt(np.maximum(values, 0.0))
        count = self._parameters.max_particles
        self.particles: NDArray[np.float64] = np.array(pose) + self._random.standard_normal((count, 3)) @ spread.T
        self.weights: NDArray[np.float64] = np.full(count, 1.0 / count)
        self._odom = None
        self._updates = 0
        self.estimate = PoseEstimate(pose, covariance)

    def needs_update(self, odom: Pose2D) -> bool:
        """Tell whether the robot has moved enough since the last update, or there was none yet."""
        if self._odom is None:
            return True
        moved = self._odom.distance_to(odom) >= self._parameters.update_min_d
        return moved or abs(wrap_angle(odom.theta - self._odom.theta)) >= self._parameters.update_min_a

    def update(self, odom: Pose2D, beams: NDArray[np.float64], range_max: float) -> PoseEstimate:
        """Move the particles by odometry, weigh them by a scan, and draw anew.

        Parameters
        ----------
        odom : Pose2D
            Pose of the robot in the odometry frame when the scan was taken.
        beams : (m, 2) array
            End points of the beams that hit something, in the robot's frame [m]; with none the odometry alone counts.
        range_max : float
            Longest range of the laser [m].

        Returns
        -------
        PoseEstimate
            Pose in the map frame.
        """
        if self._odom is not None:
            self._move(self._odom, odom)
        self._odom = odom
        if len(beams):
            self._weigh(beams, range_max)
        self.estimate = estimate(self.particles, self.weights)
        self._updates += 1
        if self._updates % self._parameters.resample_interval == 0:
            self._resample()
        return self.estimate

    def _move(self, before: Pose2D, after: Pose2D) -> None:
        distance = before.distance_to(after)
        heading = math.atan2(after.y - before.y, after.x - before.x)
        first = wrap_angle(heading - before.theta) if distance >= _TURN_IN_PLACE else 0.0
        second = wrap_angle(after.theta - before.theta - first)
        normals = self._random.standard_normal((len(self.particles), 3))
        sample_motion(self.particles, first, distance, second, self._alphas, normals)

    def _weigh(self, beams: NDArray[np.float64], range_max: float) -> None:
        likelihood = self._likelihoods(range_max)
        self.weights *= score_scan(self.particles, beams, self._distance, self._resolution, self._origin, likelihood)
        self.weights /= self.weights.sum()

    def _likelihoods(self, range_max: float) -> NDArray[np.float64]:
        p = self._parameters
        if self._likelihood is None or self._likelihood[0] != range_max:
            z_random = p.laser_z_rand / range_max
            table = likelihoods(
                self._resolution, p.laser_z_hit, z_random, p.laser_sigma_hit, p.laser_likelihood_max_dist
            )
            self._likelihood = range_max, table
        return self._likelihood[1]

    def _resample(self) -> None:
        count = self._adapted_count()
        drawn = draw_low_variance(self.weights, count, self._random.random())
        self.particles = self.particles[drawn]
        self.weights = np.full(count, 1.0 / count)

    def _adapted_count(self) -> int:
        """Return how many particles do: drawn one by one until they are enough for the bins they fill (KLD)."""
        p = self._parameters
        cumulative = np.cumsum(self.weights)
        picks = np.searchsorted(cumulative, self._random.random(p.max_particles) * cumulative[-1], side="right")
        bins = bins_of(self.particles)[np.minimum(picks, len(self.particles) - 1)]
        _, first = np.unique(bins, return_index=True)
        filled = np.zeros(p.max_particles, dtype=np.int64)
        filled[first] = 1
        enough = _kld_limit(np.cumsum(filled), p.kld_err, p.kld_z) <= np.arange(1, p.max_particles + 1)
        count = int(np.argmax(enough)) + 1 if enough.any() else p.max_particles
        return max(count, p.min_particles)


def _kld_limit(bins: NDArray[np.int64], error: float, z: float) -> NDArray[np.float64]:
    """Return how many particles keep the Kullback-Leibler distance under ``error``, by the bins that are filled.

    Fox, *KLD-Sampling: Adaptive Particle Filters* (2001), equation 7; ``z`` is the quantile itself, as amcl has it.
    """
    k = np.maximum(bins - 1, 1).astype(np.float64)
    a = 2.0 / (9.0 * k)
    limit: NDArray[np.float64] = k / (2.0 * error) * (1.0 - a + np.sqrt(a) * z) ** 3
    return limit
