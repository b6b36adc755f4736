"""Adaptive Monte Carlo localization: a particle filter with KLD sampling.

Thrun, Burgard, Fox, *Probabilistic Robotics* (2005), tables 5.6, 6.3, 8.3 and 8.4; names and defaults are amcl's.
"""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.localization.kernels.resample import draw_low_variance, kld_sample_size
from ppaas.localization.odometry import odometry_model
from ppaas.localization.parameters import AmclParameters
from ppaas.localization.pose_estimate import PoseEstimate, estimate
from ppaas.localization.pose_search import PoseCandidates, PoseSearch
from ppaas.localization.relocalization import Relocalizer
from ppaas.localization.sensor_model import sensor_model
from ppaas.thread_budget import Threads, one_thread

BLUR = np.array((0.05, 0.05, 0.02))
"""Standard deviation of particles around a pose candidate, so that no two are the same [m, m, rad]."""


TURN_NOISE = 0.01
"""Noise of a turn that is not worth adding: the noise of each motion is larger [rad]."""


class ParticleFilter:
    """Tracks the pose of a robot in a map.

    Parameters
    ----------
    layers : MapLayers
        The map.
    parameters : AmclParameters
        The same seed and the same input give the same particles.
    threads : callable
        Returns the largest number of threads that kernels may use now; it does not affect the result.

    Attributes
    ----------
    particles : (n, 3) array
        x, y [m], theta [rad].
    weights : (n,) array
        Weights of the particles, with sum 1.
    estimate : PoseEstimate
        Result of the last update.
    """

    def __init__(self, layers: MapLayers, parameters: AmclParameters, threads: Threads = one_thread) -> None:
        self._parameters, self._threads = parameters, threads
        self._random = np.random.default_rng(parameters.seed)
        self._odometry = odometry_model(parameters, threads)
        self._relocalizer = Relocalizer(layers, parameters, self._random)
        self.sensor = sensor_model(layers, parameters, threads)
        self.initialise(Pose2D(0.0, 0.0), np.zeros((3, 3)))

    def use_layers(self, layers: MapLayers) -> None:
        """Replace the map by another in the same frame; the particles and the estimate stay."""
        self.sensor = sensor_model(layers, self._parameters, self._threads)
        self._relocalizer.use_layers(layers)

    # -- initial particles ---------------------------------------------------------------------------------------------

    def initialise(self, pose: Pose2D, covariance: NDArray[np.float64]) -> None:
        """Start over with particles around a pose.

        Parameters
        ----------
        pose : Pose2D
            In the map frame.
        covariance : (3, 3) array
            Covariance of x [m], y [m], theta [rad].

        Raises
        ------
        InvalidInput
            A number is not finite, or the covariance is not positive semi-definite.
        """
        if not (pose.is_finite() and np.isfinite(covariance).all()):
            raise InvalidInput("an initial pose and its covariance must be finite")
        values, vectors = np.linalg.eigh((covariance + covariance.T) / 2.0)
        if values.min() < -1e-9:
            raise InvalidInput("the covariance of an initial pose must be positive semi-definite")
        spread = vectors * np.sqrt(np.maximum(values, 0.0))
        count = self._parameters.max_particles
        self._begin(np.array(pose) + self._random.standard_normal((count, 3)) @ spread.T)
        self._relocalizer.begin(searching=False)
        self._scattered = False
        self.estimate = PoseEstimate(pose, covariance)

    def initialise_globally(self) -> None:
        """Start over with particles in all free cells, until the search with the next scan finds better ones.

        Raises
        ------
        InvalidMap
            No cell of the map is free.
        """
        self._begin(self._relocalizer.free.draw(self._parameters.max_particles, self._random))
        self._relocalizer.begin(searching=True)
        self._scattered = True
        self.estimate = estimate(self.particles, self.weights)

    def _begin(self, particles: NDArray[np.float64]) -> None:
        self._set(particles)
        self._odom: Pose2D | None = None
        self._updates = 0

    def _set(self, particles: NDArray[np.float64]) -> None:
        self.particles: NDArray[np.float64] = particles
        self.weights: NDArray[np.float64] = np.full(len(particles), 1.0 / len(particles))

    def rebase(self, jump: Pose2D) -> None:
        """Continue after a reset of the odometry; ``jump`` is the pose of the new odometry frame in the old one."""
        if self._odom is not None:
            self._odom = jump.inverse() @ self._odom
            self._relocalizer.rebase(jump)

    # -- updates -------------------------------------------------------------------------------------------------------

    def needs_update(self, odom: Pose2D) -> bool:
        """Return whether the robot has moved far enough since the last update, or there was none yet."""
        if self._odom is None:
            return True
        moved = self._odom.distance_to(odom) >= self._parameters.update_min_d
        return moved or abs(wrap_angle(odom.theta - self._odom.theta)) >= self._parameters.update_min_a

    def update(self, odom: Pose2D, beams: NDArray[np.float64], range_max: float) -> PoseEstimate:
        """Move the particles by odometry, weight them by a scan, and resample.

        Parameters
        ----------
        odom : Pose2D
            Pose of the robot in the odometry frame when the scan was taken.
        beams : (m, k) array
            Beams of the scan from ``sensor.beams``; if empty, only the odometry is used.
        range_max : float
            Longest range of the laser from ``sensor.range_max`` [m].

        Returns
        -------
        PoseEstimate
            Pose in the map frame.
        """
        about = self.estimate.pose
        if self._odom is not None:
            about = about @ self._odom.inverse() @ odom
            self._odometry.move(self.particles, self._odom, odom, self._random)
        self._odom = odom
        fit = self._weigh(beams, range_max, about) if len(beams) else None
        self.estimate = estimate(self.particles, self.weights)
        if fit is not None:
            self._relocalizer.note(fit, odom, self.sensor.points(beams, range_max), self.estimate.pose)
        self._updates += 1
        if self._updates % self._parameters.resample_interval == 0:
            self._resample()
        return self.estimate

    def expected(self, odom: Pose2D) -> PoseEstimate:
        """Return the estimate of the last update, moved by odometry since."""
        if self._odom is None:
            return self.estimate
        return replace(self.estimate, pose=self.estimate.pose @ self._odom.inverse() @ odom)

    def correct(self, odom: Pose2D, pose: Pose2D) -> None:
        """Shift and turn all particles, so that the expected pose is ``pose`` when the odometry is ``odom``."""
        assert self._odom is not None
        before, after = self.estimate.pose, pose @ odom.inverse() @ self._odom
        away = after.x - before.x, after.y - before.y, wrap_angle(after.theta - before.theta)
        self.particles = self.particles + away
        self.particles[:, 2] = (self.particles[:, 2] + math.pi) % (2.0 * math.pi) - math.pi
        self.estimate = replace(self.estimate, pose=after)

    def spread_heading(self, deviation: float) -> None:
        """Turn each particle by noise with a standard deviation, if it is more than `TURN_NOISE` [rad]."""
        if deviation > TURN_NOISE:
            self.particles = self.particles.copy()
            self.particles[:, 2] += deviation * self._random.standard_normal(len(self.particles))

    def _weigh(self, beams: NDArray[np.float64], range_max: float, about: Pose2D) -> float:
        """Weight the particles, which are near ``about`` unless the robot is lost; return how well the scan fits."""
        fit = self.sensor.fit(self.particles, beams, range_max)
        mean_fit = float((self.weights * fit.fits).sum())
        # As long as the robot may be anywhere, there is no pose from which beams could be judged.
        informative = beams if self.searching else self.sensor.informative(beams, about)
        if not len(informative):
            return mean_fit
        if len(informative) < len(beams):
            fit = self.sensor.fit(self.particles, informative, range_max)
        self.weights *= fit.weights
        self.weights /= self.weights.sum()
        return mean_fit

    def _resample(self) -> None:
        p = self._parameters
        picks = self._random.random(p.max_particles)
        count = kld_sample_size(self.particles, self.weights, picks, p.min_particles, p.kld_err, p.kld_z)
        self._set(self.particles[self._drawn(self.weights, count)])

    def _drawn(self, weights: NDArray[np.float64], count: int) -> NDArray[np.int64]:
        return draw_low_variance(weights, count, self._random.random())

    # -- robots that are lost ------------------------------------------------------------------------------------------

    @property
    def searching(self) -> bool:
        """Whether the robot may be anywhere on the map, and was not found yet."""
        return self._relocalizer.searching

    def next_search(self) -> PoseSearch | None:
        """Return the search to run next, once, or None; ``run`` takes long, and its result goes to `adopt`."""
        return self._relocalizer.next_search()

    def adopt(self, found: PoseCandidates) -> bool:
        """Redraw particles from the candidates of a search; return whether any were redrawn.

        None are if the filter was restarted in the meantime, or if the robot is most likely at its current estimate.
        """
        if self._odom is None or not self._relocalizer.is_current(found):
            return False
        share = self._relocalizer.redraw_share(found)
        if not share:
            return False
        # The robot drove on while the search ran.
        moved = found.search.odom.inverse() @ self._odom
        poses = np.array([Pose2D(*pose) @ moved for pose in found.poses.tolist()])
        count = self._parameters.max_particles
        # Particles in all free cells are no hypothesis that is worth keeping.
        redrawn = count if self._scattered else round(count * share)
        drawn = poses[self._drawn(found.weights, redrawn)] + BLUR * self._random.standard_normal((redrawn, 3))
        self._set(np.concatenate((self.particles[self._drawn(self.weights, count - redrawn)], drawn)))
        self._scattered = False
        self.estimate = estimate(self.particles, self.weights)
        self._relocalizer.judge(poses, found.weights, self.estimate)
        return True
