"""Global pose search: candidate poses on the whole map, from the scans of the last metres.

As in Lenser and Veloso, *Sensor Resetting Localization for Poorly Modelled Mobile Robots* (2000), particles are drawn
from what the sensors see. Of many random poses the search keeps those that fit best, and improves each in small random
steps. Without these steps a pose near the true one fits worse than many poses in places that merely look similar.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap
from ppaas.geometry import Pose2D
from ppaas.localization.beams import choose_beams
from ppaas.localization.kernels.free_cells import count_free, find_free
from ppaas.localization.scan_match import ScanMatch
from ppaas.maps.grid import GridMap

# -- uniform samples of free poses -------------------------------------------------------------------------------------


class FreePoses:
    """Draws poses uniformly from the free cells of a map.

    Parameters
    ----------
    grid : GridMap
    """

    def __init__(self, grid: GridMap) -> None:
        self._grid = grid
        self._counted: NDArray[np.int64] | None = None

    @property
    def area(self) -> float:
        """Area of all free cells [m²].

        Raises
        ------
        InvalidMap
            No cell of the map is free.
        """
        return float(self._below()[-1]) * self._grid.info.resolution**2

    def draw(self, count: int, random: np.random.Generator) -> NDArray[np.float64]:
        """Return poses (count, 3): x, y [m], theta [rad] in the map frame.

        Raises
        ------
        InvalidMap
            No cell of the map is free.
        """
        below, info = self._below(), self._grid.info
        cells = find_free(self._grid.data, below, np.sort(random.integers(0, int(below[-1]), count)))
        centres = info.to_world(cells + random.random((count, 2)) - 0.5)
        return np.column_stack((centres, random.uniform(-math.pi, math.pi, count)))

    def _below(self) -> NDArray[np.int64]:
        """Return for each row the number of free cells in it and all rows below it, counted at the first call."""
        if self._counted is None:
            self._counted = count_free(self._grid.data)
        if not self._counted[-1]:
            raise InvalidMap("the map has no free cell, so no robot can be in it; publish a map with free cells")
        return self._counted


# -- the search --------------------------------------------------------------------------------------------------------

TRIES_PER_AREA = 250.0
"""Random poses per square metre of free space: one in 0.4 m by 0.4 m by 10°."""

LEAST_TRIES, TRIES = 20_000, 400_000
"""Smallest and largest number of random poses."""

CHUNK = 1 << 14
"""Poses rated at once: it bounds the memory, and the time until a cancellation is noticed."""

KEPT = 3000
"""Best poses that the first round improves."""

AROUND = 8
"""Poses tried around each pose of a round, itself included."""

BIN, BIN_TURN = 0.3, math.radians(6.0)
"""Size of a bin, of which only the best pose is kept [m, rad]."""

COARSE_BEAMS, FINE_BEAMS = 30, 200
"""Beams compared with the map, chosen from all that were seen."""

LOOK = 0.1
"""Distance after which a scan is taken to be independent of the one before [m]."""


@dataclass(frozen=True, slots=True)
class _Round:
    """Round of improvement.

    Parameters
    ----------
    reach, turn : float
        Standard deviations of the random steps [m, rad].
    kept : int
        Largest number of poses that remain.
    beams : int
        Number of beams compared with the map.
    wide : float
        Factor of the standard deviation of a beam's end; a wider one smooths the fit.
    """

    reach: float
    turn: float
    kept: int
    beams: int
    wide: float


_ROUNDS = (
    _Round(0.25, math.radians(4.0), KEPT, COARSE_BEAMS, 1.7),
    _Round(0.12, math.radians(2.0), KEPT // 4, 2 * COARSE_BEAMS, 1.0),
    _Round(0.06, math.radians(1.0), KEPT // 8, FINE_BEAMS, 1.0),
    _Round(0.03, math.radians(0.5), KEPT // 8, FINE_BEAMS, 1.0),
)


@dataclass(frozen=True, slots=True)
class PoseCandidates:
    """Result of a search: candidate poses of the robot.

    Parameters
    ----------
    search : PoseSearch
        The search that found them.
    poses : (n, 3) array
        x, y [m], theta [rad] in the map frame, the best first; at most one per bin.
    weights : (n,) array
        Likelihoods of the poses, with sum 1.
    believed_odds : float
        Likelihood of the pose that was believed before the search, divided by the likelihood of all candidates
        together.
    """

    search: "PoseSearch"
    poses: NDArray[np.float64]
    weights: NDArray[np.float64]
    believed_odds: float


@dataclass(frozen=True, slots=True, eq=False)
class PoseSearch:
    """Search of the whole map. It shares no mutable state, so it may run in another thread.

    Parameters
    ----------
    free : FreePoses
    match : ScanMatch
        Rates poses against the map.
    seen : (m, 4) array
        x, y of the ends of beams, and x, y of their origins, in the robot's frame [m].
    metres : float
        Distance driven while these beams were measured [m].
    odom : Pose2D
        Pose of the robot in the odometry frame at the newest of these beams.
    believed : Pose2D
        Estimated pose of the robot in the map frame at that time.
    lost : bool
        The robot may be anywhere already, so its estimated pose gets no preference.
    seed : int
        The same seed gives the same result.
    """

    free: FreePoses
    match: ScanMatch
    seen: NDArray[np.float64]
    metres: float
    odom: Pose2D
    believed: Pose2D
    lost: bool
    seed: int

    def run(self, cancelled: Callable[[], bool]) -> PoseCandidates | None:
        """Return candidate poses, or None if the search was cancelled.

        Raises
        ------
        InvalidMap
            No cell of the map is free.
        """
        random = np.random.default_rng(self.seed)
        poses = self._drawn(random, cancelled)
        fits = np.empty(0)
        for step in _ROUNDS:
            if poses is None or cancelled():
                return None
            poses, fits = self._improved(poses, step, random)
        return None if poses is None else self._weighed(poses, fits, random)

    def _drawn(self, random: np.random.Generator, cancelled: Callable[[], bool]) -> NDArray[np.float64] | None:
        """Return the `KEPT` best of many random poses."""
        beams = choose_beams(self.seen[:, :2], COARSE_BEAMS)
        tries = int(min(max(TRIES_PER_AREA * self.free.area, LEAST_TRIES), TRIES))
        kept, known = np.empty((0, 3)), np.empty(0)
        for begin in range(0, tries, CHUNK):
            if cancelled():
                return None
            drawn = self.free.draw(min(CHUNK, tries - begin), random)
            kept = np.concatenate((kept, drawn))
            known = np.concatenate((known, self.match.fits(drawn, beams, wide=3.5)))
            top = np.argpartition(-known, KEPT)[:KEPT] if len(known) > KEPT else slice(None)
            kept, known = kept[top], known[top]
        return kept

    def _improved(
        self, poses: NDArray[np.float64], step: _Round, random: np.random.Generator
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the best pose around each pose and its fit, sorted by fit, at most one per bin."""
        tried = np.repeat(poses[:, np.newaxis], AROUND, axis=1)
        tried[:, 1:] += random.standard_normal(tried[:, 1:].shape) * (step.reach, step.reach, step.turn)
        beams = choose_beams(self.seen[:, :2], step.beams)
        fits = self.match.fits(tried.reshape(-1, 3), beams, step.wide).reshape(-1, AROUND)
        best = fits.argmax(axis=1)
        every = np.arange(len(poses))
        order = np.argsort(-fits[every, best], kind="stable")
        poses, known = tried[every, best][order], fits[every, best][order]
        apart = _apart(poses)[: step.kept]
        return poses[apart], known[apart]

    def _weighed(
        self, poses: NDArray[np.float64], fits: NDArray[np.float64], random: np.random.Generator
    ) -> PoseCandidates:
        """Weight each pose by its fit, to the power of the number of independent scans."""
        looks = 1.0 + self.metres / LOOK
        here, known = np.array([self.believed]), np.empty(0)
        for step in _ROUNDS[1:]:
            here, known = self._improved(here, step, random)
        weights = _likely(fits, looks)
        together = np.concatenate((known, fits)) if self.lost else self._accounts(np.concatenate((here, poses)))
        believed, *elsewhere = _likely(together, looks).tolist()
        return PoseCandidates(self, poses, weights / weights.sum(), believed / max(sum(elsewhere), 1e-300))

    def _accounts(self, poses: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return how well the map explains the beams, given that people may have stopped some of them.

        Beams that ended at people fit other places by chance, and better than the true pose if most beams ended so.
        Therefore only beams that people cannot explain count against the believed pose.
        """
        return self.match.accounts(poses, choose_beams(self.seen, FINE_BEAMS))


def _likely(fits: NDArray[np.float64], looks: float) -> NDArray[np.float64]:
    """Return likelihoods of poses from their fits, relative to the best."""
    likely: NDArray[np.float64] = (fits / max(float(fits.max()), 1e-9)) ** looks
    return likely


def _apart(poses: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the index of the first pose of each bin, in ascending order."""
    cells = np.floor(poses / (BIN, BIN, BIN_TURN)).astype(np.int64)
    cells[:, 2] %= round(2.0 * math.pi / BIN_TURN)
    keys = (cells[:, 0] << 40) ^ ((cells[:, 1] & 0xFFFFF) << 16) ^ cells[:, 2]
    return np.sort(np.unique(keys, return_index=True)[1])
