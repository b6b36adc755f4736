"""Scan alignment: the most likely pose of a robot near an expected pose, from what its laser sees."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D, wrap_angle
from ppaas.localization.scan_match import ScanMatch

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
