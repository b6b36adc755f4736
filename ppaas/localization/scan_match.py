"""Scan matching: how well beams fit the map, independent of the sensor model, and where near a pose they fit best."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.localization.kernels import likelihood_field
from ppaas.localization.kernels.sight import explain_rays, to_walls
from ppaas.localization.parameters import AmclParameters
from ppaas.messages.sensor_msgs import LaserScan

PERSON = 0.5
"""Rating of a beam that ends in free space, where a person may stand."""


class ScanMatch:
    """Rates poses by the distances from the ends of beams to the nearest obstacles.

    Parameters
    ----------
    layers : MapLayers
        The map; its ``distance`` is read.
    parameters : AmclParameters
    """

    def __init__(self, layers: MapLayers, parameters: AmclParameters) -> None:
        info = layers.grid.info
        self._distance, self._resolution, self._origin = layers.distance, info.resolution, np.array(info.origin)
        # The likelihood field adds the cube of a Gaussian to a weight: as narrow as a Gaussian of σ/√3.
        self._sigma = parameters.laser_sigma_hit / math.sqrt(3.0)
        self._far = parameters.laser_likelihood_max_dist
        self._tables: dict[float, NDArray[np.int64]] = {}
        self._inside: NDArray[np.int64] | None = None

    def fits(self, poses: NDArray[np.float64], points: NDArray[np.float64], wide: float = 1.0) -> NDArray[np.float64]:
        """Return the fit of points to the map as seen from each pose, from 0 to 1.

        Parameters
        ----------
        poses : (n, 3) array
            x, y [m], theta [rad] in the map frame.
        points : (m, 2) array
            End points of beams in the robot's frame [m]; at least one.
        wide : float
            Factor of the standard deviation of a point.
        """
        table = self._tables.get(wide)
        if table is None:
            table = self._tables[wide] = np.rint(self._gauss(wide) * likelihood_field.ONE).astype(np.int64)
        return self._mean(poses, points, table)

    def surface_fits(self, poses: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the fit of points to the surfaces of walls as seen from each pose, up to 1.

        By `fits`, a pose is as good if the points are deep in a wall, which would pull a robot that sees few walls by
        half of their thickness. Here a point counts as one cell away if it is still in the wall one cell nearer to the
        robot.

        Parameters
        ----------
        poses, points
            As for `fits`.
        """
        if self._inside is None:
            gauss = self._gauss(1.0)
            self._inside = np.zeros(len(gauss), np.int64)
            self._inside[0] = np.rint((gauss[1] - gauss[0]) * likelihood_field.ONE)
        ranges = np.hypot(points[:, 0], points[:, 1])
        nearer = points * (1.0 - self._resolution / np.maximum(ranges, self._resolution))[:, np.newaxis]
        return self.fits(poses, points) + self._mean(poses, nearer, self._inside)

    def _gauss(self, wide: float) -> NDArray[np.float64]:
        return likelihood_field.likelihoods(self._resolution, 1.0, 0.0, wide * self._sigma, self._far)

    def _mean(
        self, poses: NDArray[np.float64], points: NDArray[np.float64], table: NDArray[np.int64]
    ) -> NDArray[np.float64]:
        """Return the mean term of a table over the points, as seen from each pose."""
        sums = likelihood_field.score_serial(poses, points, self._distance, self._resolution, self._origin, table)
        found: NDArray[np.float64] = sums / len(points)
        return found

    def accounts(self, poses: NDArray[np.float64], rays: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return how well the map explains rays as seen from each pose, from 0 to 1.

        Unlike `fits`, it rates a ray low that would have had to pass through a wall, and is more lenient with a ray
        that ends in free space, where an unmapped person may stand.

        Parameters
        ----------
        poses : (n, 3) array
            x, y [m], theta [rad] in the map frame.
        rays : (m, 4) array
            x, y of the end and x, y of the origin of each ray, in the robot's frame [m]; at least one.
        """
        sums: NDArray[np.float64] = explain_rays(
            poses, rays, self._distance, self._resolution, self._origin, self._sigma, PERSON
        )
        return sums / len(rays)


# -- alignment near an expected pose -----------------------------------------------------------------------------------

EVIDENCE = 0.5
"""Part of the points that count as independent: neighbouring points lie on one wall."""

JUMP = np.array((0.05, 0.05, 0.1))
"""Standard deviation of the motion of a robot that slipped or was pushed [m, m, rad]."""

JUMPED = 1e-3
"""Prior probability that the robot slipped or was pushed since the last alignment."""

HEADING_STEP, LEAST_TURN = 0.01, 0.2
"""Step of the search over headings, and the smallest angle to each side that it covers [rad]."""

COARSE = 1.5
"""Factor of the standard deviation of a point while headings are searched; it smooths the fit."""

DRAWN = 100
"""Number of poses drawn from each part of the prior; as many are drawn from the refined distribution."""

NARROW, WIDE = np.array((np.inf, np.inf, 0.03)), np.array((np.inf, np.inf, 0.05))
"""Largest standard deviations of the poses drawn around the best heading [m, m, rad]."""

_random = np.random.default_rng(0)
_half = _random.standard_normal((DRAWN // 2, 3))
_NORMALS = np.concatenate((np.zeros((1, 3)), _half, -_half))
"""Standard normal numbers, in pairs that cancel; the same for every alignment, so that equal scans give equal poses."""


class Alignment(NamedTuple):
    """Result of an alignment.

    Parameters
    ----------
    pose : Pose2D
        Mean of the poses by their likelihood, in the map frame.
    covariance : (3, 3) array
        Covariance of x [m], y [m], theta [rad].
    fit : float
        Fit of the points at the best pose, from 0 to 1.
    """

    pose: Pose2D
    covariance: NDArray[np.float64]
    fit: float

    @property
    def deviations(self) -> tuple[float, float, float]:
        """Standard deviations of x [m], y [m], theta [rad]."""
        x, y, theta = np.sqrt(np.diag(self.covariance)).tolist()
        return x, y, theta


def align(match: ScanMatch, points: NDArray[np.float64], expected: Pose2D, spread: NDArray[np.float64]) -> Alignment:
    """Return the mean of the poses near an expected pose, weighted by how well the points fit (importance sampling).

    In a direction that the points do not determine, such as along a corridor, the pose stays the expected one, and the
    covariance the prior's. The prior has a second, wider part, so that a robot that slipped is followed.

    Parameters
    ----------
    match : ScanMatch
        Rates poses against the map.
    points : (n, 2) array
        End points of beams in the robot's frame [m]; at least one.
    expected : Pose2D
        Expected pose of the robot in the map frame.
    spread : (3,) array
        Standard deviations of x [m], y [m] and theta [rad] around it; above 0.
    """
    search = _Search(match, points, expected, spread)
    about = np.array((0.0, 0.0, search.heading()))
    narrow, wide = np.minimum(spread, NARROW), np.minimum(search.wide, WIDE)
    steps = np.concatenate((_NORMALS * narrow, _NORMALS * wide))
    proposed = np.logaddexp(_log_gauss(steps, narrow), _log_gauss(steps, wide))
    about, covariance, _ = search.weighed(about + steps, proposed)
    # A second draw, from what the first one has found: the first has few poses where the points fit best.
    refined = 1.2 * np.sqrt(np.diag(covariance)) + 1e-4
    steps = _NORMALS * refined
    about, covariance, fit = search.weighed(about + steps, _log_gauss(steps, refined))
    pose = Pose2D(
        expected.x + float(about[0]), expected.y + float(about[1]), wrap_angle(expected.theta + float(about[2]))
    )
    return Alignment(pose, covariance, fit)


class _Search:
    """Prior and likelihood of the difference from the expected pose."""

    def __init__(
        self, match: ScanMatch, points: NDArray[np.float64], expected: Pose2D, spread: NDArray[np.float64]
    ) -> None:
        self._match, self._points, self._expected = match, points, np.array(expected)
        self._evidence = EVIDENCE * len(points)
        self._spread, self.wide = spread, np.hypot(spread, JUMP)

    def heading(self) -> float:
        """Return the most likely difference of the heading, at the expected position [rad]."""
        most = min(max(3.0 * float(self._spread[2]), LEAST_TURN), math.pi)
        count = math.ceil(most / HEADING_STEP)
        away = np.zeros((2 * count + 1, 3))
        away[:, 2] = np.linspace(-most, most, len(away))
        fits = self._match.fits(self._expected + away, self._points, COARSE)
        best: float = away[self._log_posterior(away, fits).argmax(), 2]
        return best

    def weighed(
        self, away: NDArray[np.float64], proposed: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
        """Return mean and covariance of differences drawn with log densities ``proposed``, and the best fit."""
        fits = self._match.surface_fits(self._expected + away, self._points)
        logs = self._log_posterior(away, fits)
        weights = np.exp(logs - proposed - (logs - proposed).max())
        weights /= weights.sum()
        mean = weights @ away
        apart = away - mean
        return mean, (weights[:, np.newaxis] * apart).T @ apart, float(fits.max())

    def _log_posterior(self, away: NDArray[np.float64], fits: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the log posterior densities of differences from the expected pose, up to a constant."""
        usual = _log_gauss(away, self._spread) + math.log(1.0 - JUMPED)
        jumped = _log_gauss(away, self.wide) + math.log(JUMPED)
        logs: NDArray[np.float64] = self._evidence * fits + np.logaddexp(usual, jumped)
        return logs


def _log_gauss(away: NDArray[np.float64], spread: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the log density of differences with these standard deviations, up to a constant."""
    found: NDArray[np.float64] = -0.5 * ((away / spread) ** 2).sum(axis=1) - np.log(spread).sum()
    return found


# -- plausibility: a laser that is covered, broken or switched off -----------------------------------------------------

MOST_RAYS = 36
"""Largest number of beams of a scan that are compared with the map."""

IN_REACH, MARGIN = 0.9, 0.3
"""A laser must see a wall that is nearer than this part of its longest range, and farther by this than its shortest
range [m]."""

SHOULD_SEE = 0.5
"""Part of the beams that must see a wall, from which a laser without readings counts as blind."""


def check_plausible(scan: LaserScan, layers: MapLayers, place: Callable[[], Pose2D | None]) -> None:
    """Reject a scan without readings if the laser must see walls: its robot would drive blind.

    A single beam without a reading is normal: drivers report null, NaN, infinity or 0 if nothing is in reach.

    Parameters
    ----------
    scan : LaserScan
        Its angles must be finite.
    layers : MapLayers
        The map.
    place : callable
        Returns the estimated pose of the laser in the map frame, or None; called only if no beam has a reading.

    Raises
    ------
    InvalidInput
        No beam has a reading, although by the map half of them should see a wall.
    """
    ranges = scan.ranges
    if not ranges or any(each is not None and scan.range_min < each < scan.range_max for each in ranges):
        return
    laser = place()
    if laser is None:
        return
    chosen = np.linspace(0, len(ranges) - 1, min(MOST_RAYS, len(ranges))).round()
    angles, info = scan.angle_min + scan.angle_increment * chosen, layers.grid.info
    away = to_walls(np.array(laser), angles, layers.distance, info.resolution, np.array(info.origin), scan.range_max)
    in_sight = (away > scan.range_min + MARGIN) & (away < IN_REACH * scan.range_max)
    if np.mean(in_sight) >= SHOULD_SEE:
        raise InvalidInput(
            "no beam of the scan has a reading, although by the map half of them should: check that the laser is on, "
            "and that the robot is at its estimated pose"
        )
