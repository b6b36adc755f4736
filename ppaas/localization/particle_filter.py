"""Adaptive Monte Carlo localization: particles that are moved, weighed by scans, and drawn anew, as many as it takes.

Thrun, Burgard, Fox, *Probabilistic Robotics* (2005), tables 5.6, 6.3, 8.3 and 8.4; names and defaults are amcl's.
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.localization.kernels.resample import draw_low_variance, enough
from ppaas.localization.odometry import odometry_model
from ppaas.localization.parameters import AmclParameters
from ppaas.localization.pose_estimate import PoseEstimate, estimate
from ppaas.localization.pose_search import Found, Search
from ppaas.localization.relocalization import Seeker
from ppaas.localization.sensor_model_choice import sensor_model
from ppaas.thread_budget import Threads, one_thread

BLUR = np.array((0.05, 0.05, 0.02))
"""Around a place that was found, so that no two particles are the same [m, m, rad]."""


class ParticleFilter:
    """Tracks a robot in a map.

    Parameters
    ----------
    layers : MapLayers
        The map.
    parameters : AmclParameters
        The same seed and the same input give the same particles.
    threads : callable
        Returns the most threads that kernels may use now; the result is the same for any number.

    Attributes
    ----------
    particles : (n, 3) array
        x, y [m], theta [rad].
    weights : (n,) array
        Sum 1.
    estimate : PoseEstimate
        Of the last update.
    """

    def __init__(self, layers: MapLayers, parameters: AmclParameters, threads: Threads = one_thread) -> None:
        self._parameters = parameters
        self._random = np.random.default_rng(parameters.seed)
        self._odometry = odometry_model(parameters, threads)
        self._seeker = Seeker(layers, parameters, self._random)
        self.sensor = sensor_model(layers, parameters, threads)
        self.initialise(Pose2D(0.0, 0.0), np.zeros((3, 3)))

    # -- where it begins -----------------------------------------------------------------------------------------------

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
        self._begin(np.array(pose) + self._random.standard_normal((count, 3)) @ spread.T)
        self._seeker.begin(searching=False)
        self._scattered = False
        self.estimate = PoseEstimate(pose, covariance)

    def initialise_globally(self) -> None:
        """Start anew all over the free cells; what is found by the next scan takes their place.

        Raises
        ------
        InvalidMap
            No cell of the map is free.
        """
        self._begin(self._seeker.free.draw(self._parameters.max_particles, self._random))
        self._seeker.begin(searching=True)
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
        """Take note that odometry began anew; ``jump`` is the pose of its new frame in the one before."""
        if self._odom is not None:
            self._odom = jump.inverse() @ self._odom
            self._seeker.rebase(jump)

    # -- updates -------------------------------------------------------------------------------------------------------

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
        beams : (m, k) array
            Of the scan, as ``sensor.beams`` gives them; with none the odometry alone counts.
        range_max : float
            Longest range of the laser, as ``sensor.range_max`` gives it [m].

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
            self._seeker.note(fit, odom, self.sensor.points(beams, range_max), self.estimate.pose)
        self._updates += 1
        if self._updates % self._parameters.resample_interval == 0:
            self._resample()
        return self.estimate

    def _weigh(self, beams: NDArray[np.float64], range_max: float, about: Pose2D) -> float:
        """Weigh the particles, which are about there unless the robot is lost; return how well the scan fits."""
        fit = self.sensor.fit(self.particles, beams, range_max)
        fits = float((self.weights * fit.fits).sum())
        telling = beams if self.searching else self.sensor.telling(beams, about)
        if not len(telling):
            return fits
        if len(telling) < len(beams):
            fit = self.sensor.fit(self.particles, telling, range_max)
        self.weights *= fit.weights
        self.weights /= self.weights.sum()
        return fits

    def _resample(self) -> None:
        p = self._parameters
        picks = self._random.random(p.max_particles)
        count = enough(self.particles, self.weights, picks, p.min_particles, p.kld_err, p.kld_z)
        self._set(self.particles[self._drawn(self.weights, count)])

    def _drawn(self, weights: NDArray[np.float64], count: int) -> NDArray[np.int64]:
        return draw_low_variance(weights, count, self._random.random())

    # -- robots that are lost ------------------------------------------------------------------------------------------

    @property
    def searching(self) -> bool:
        """Tell whether the robot may be anywhere, and was not found yet."""
        return self._seeker.searching

    def next_search(self) -> Search | None:
        """Return where to look now, once; its ``run`` takes long, and what it returns is for `adopt`."""
        return self._seeker.next_search()

    def adopt(self, found: Found) -> bool:
        """Draw particles where the robot may be; tell whether any were.

        None are where all has begun anew meanwhile, or where the robot is most likely where it is taken to be.
        """
        if self._odom is None or not self._seeker.is_current(found):
            return False
        share = self._seeker.share_anew(found)
        if not share:
            return False
        moved = found.search.odom.inverse() @ self._odom
        poses = np.array([Pose2D(*pose) @ moved for pose in found.poses.tolist()])
        count = self._parameters.max_particles
        anew = count if self._scattered else round(count * share)
        drawn = poses[self._drawn(found.weights, anew)] + BLUR * self._random.standard_normal((anew, 3))
        self._set(np.concatenate((self.particles[self._drawn(self.weights, count - anew)], drawn)))
        self._scattered = False
        self.estimate = estimate(self.particles, self.weights)
        self._seeker.judge(poses, found.weights, self.estimate)
        return True
