"""Where in a map a robot may be, by all that its laser saw on the last metres.

As in Lenser and Veloso, *Sensor Resetting Localization for Poorly Modelled Mobile Robots* (2000), particles are drawn
where the sensors say that the robot is. Of many poses all over the map those that fit best are kept; each is moved
little by little to where it fits better. Without that, a pose near the robot fits worse than many that only look alike.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.localization.beams import choose_beams
from ppaas.localization.free_poses import FreePoses
from ppaas.localization.scan_match import Match

TRIES_PER_AREA = 250.0
"""Poses tried for each square metre that is free: one in 0.4 m by 0.4 m by 10°."""

LEAST_TRIES, TRIES = 20_000, 400_000
"""But no fewer, and no more in all."""

CHUNK = 1 << 14
"""Poses that are tried at a time: memory does not grow with how many are tried, and who waits is not kept waiting."""

KEPT = 3000
"""Poses that are moved to where they fit better, at first."""

AROUND = 8
"""Poses that are tried around each, itself among them."""

BIN, BIN_TURN = 0.3, math.radians(6.0)
"""Of two that are nearer to each other than about this [m, rad], the better is kept."""

COARSE_BEAMS, FINE_BEAMS = 30, 200
"""Beams that are compared with the map, out of all that were seen."""

LOOK = 0.1
"""After so many metres what a laser sees says something new."""


@dataclass(frozen=True, slots=True)
class _Round:
    """How far around a pose others are tried [m, rad], how many of them are kept, and by what they are compared."""

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
class Found:
    """Poses that fit.

    Parameters
    ----------
    search : Search
    poses : (n, 3) array
        x, y [m], theta [rad] in the map frame, no two of them at one place; the best first.
    weights : (n,) array
        How likely each is, sum 1.
    told : float
        How likely the place is where the robot was taken to be, against all of these.
    """

    search: "Search"
    poses: NDArray[np.float64]
    weights: NDArray[np.float64]
    told: float


@dataclass(frozen=True, slots=True, eq=False)
class Search:
    """One look over the whole map. It shares nothing that changes: it may run in another thread.

    Parameters
    ----------
    free : FreePoses
    match : Match
        Compares with the map.
    seen : (m, 4) array
        x, y where beams ended, and where they began, in the robot's frame [m].
    metres : float
        Way on which that was seen [m].
    odom : Pose2D
        Of the robot in the odometry frame when the last of it was seen.
    told : Pose2D
        Where the robot was taken to be then.
    lost : bool
        It may be anywhere already: where it was taken to be has no more to say for it than elsewhere.
    seed : int
        The same seed finds the same.
    """

    free: FreePoses
    match: Match
    seen: NDArray[np.float64]
    metres: float
    odom: Pose2D
    told: Pose2D
    lost: bool
    seed: int

    def run(self, cancelled: Callable[[], bool]) -> Found | None:
        """Return poses that fit, or None if it was cancelled.

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
        """Return the best of many poses all over the map."""
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
        """Return for each pose the best around it, and how well it fits; the best first, and one at each place."""
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

    def _weighed(self, poses: NDArray[np.float64], fits: NDArray[np.float64], random: np.random.Generator) -> Found:
        """Weigh each pose by how well all fits, as if each look had weighed it."""
        looks = 1.0 + self.metres / LOOK
        here, known = np.array([self.told]), np.empty(0)
        for step in _ROUNDS[1:]:
            here, known = self._improved(here, step, random)
        weights = _likely(fits, looks)
        together = np.concatenate((known, fits)) if self.lost else self._accounts(np.concatenate((here, poses)))
        told, *elsewhere = _likely(together, looks).tolist()
        return Found(self, poses, weights / weights.sum(), told / max(sum(elsewhere), 1e-300))

    def _accounts(self, poses: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return how well the map accounts for what was seen, whoever stood in the way.

        Points that people left fit here and there by chance, better than where the robot is if they are most of what it
        sees. So against where a robot that may be there is taken to be counts only what people do not account for.
        """
        return self.match.accounts(poses, choose_beams(self.seen, FINE_BEAMS))


def _likely(fits: NDArray[np.float64], looks: float) -> NDArray[np.float64]:
    likely: NDArray[np.float64] = (fits / max(float(fits.max()), 1e-9)) ** looks
    return likely


def _apart(poses: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return, ascending, the first pose of each bin."""
    cells = np.floor(poses / (BIN, BIN, BIN_TURN)).astype(np.int64)
    cells[:, 2] %= round(2.0 * math.pi / BIN_TURN)
    keys = (cells[:, 0] << 40) ^ ((cells[:, 1] & 0xFFFFF) << 16) ^ cells[:, 2]
    return np.sort(np.unique(keys, return_index=True)[1])
