"""Relocalization: decides whether a robot is lost, and which search of the map to run then."""

import math
from collections import deque
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.map_layers import MapLayers
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.localization.parameters import AmclParameters
from ppaas.localization.pose_estimate import PoseEstimate, weight_around
from ppaas.localization.pose_search import FreePoses, PoseCandidates, PoseSearch
from ppaas.localization.scan_match import ScanMatch

# -- scans of the last metres: one fits many places of a map, several together fit few ---------------------------------

SPACING, SPACING_TURN = 0.4, 0.6
"""Distance or turn from the scan before at which a scan is kept [m, rad]."""

SCANS = 12
"""Number of scans kept; odometry has drifted too far since older ones."""


class ScanHistory:
    """The last scans with the odometry of each."""

    def __init__(self) -> None:
        self._scans: deque[tuple[Pose2D, NDArray[np.float64]]] = deque(maxlen=SCANS)

    def note(self, odom: Pose2D, points: NDArray[np.float64]) -> bool:
        """Keep a scan if the robot has moved since the last one; return whether it was kept.

        Parameters
        ----------
        odom : Pose2D
            Pose of the robot in the odometry frame.
        points : (n, 2) array
            End points of beams in the robot's frame [m].
        """
        if self._scans:
            last = self._scans[-1][0]
            if last.distance_to(odom) < SPACING and abs(wrap_angle(odom.theta - last.theta)) < SPACING_TURN:
                return False
        self._scans.append((odom, points))
        return True

    def seen(self) -> NDArray[np.float64]:
        """Return the beams of all scans, in the robot's frame at the newest scan.

        Returns
        -------
        (m, 4) array
            x, y of the end of a beam, and x, y of the robot that measured it [m].
        """
        here = self._scans[-1][0].inverse()
        return np.concatenate([_rays(points, here @ odom) for odom, points in self._scans])

    @property
    def metres(self) -> float:
        """Distance driven from the oldest scan to the newest [m]."""
        poses = [odom for odom, _ in self._scans]
        return sum((before.distance_to(after) for before, after in pairwise(poses)), 0.0)

    @property
    def full(self) -> bool:
        """Whether each new scan replaces an older one."""
        return len(self._scans) == SCANS

    def rebase(self, jump: Pose2D) -> None:
        """Continue after a reset of the odometry; ``jump`` is the pose of the new odometry frame in the old one."""
        back = jump.inverse()
        self._scans = deque(((back @ odom, points) for odom, points in self._scans), SCANS)

    def forget(self) -> None:
        """Remove all scans."""
        self._scans.clear()


def _rays(points: NDArray[np.float64], pose: Pose2D) -> NDArray[np.float64]:
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    rays = np.empty((len(points), 4))
    rays[:, 2:] = pose.x, pose.y
    rays[:, :2] = points @ np.array(((c, s), (-s, c))) + rays[:, 2:]
    return rays


# -- the decision ------------------------------------------------------------------------------------------------------

FOUND = 0.8
"""Part of the weight near one pose, both of particles and of candidates, at which the robot counts as found."""

LOST = 0.1
"""Prior probability that a robot is lost whose recent scans fit worse."""

LEAST_SHARE, MOST_SHARE = 0.05, 0.9
"""Smallest and largest part of the particles that are redrawn for a lost robot."""

AMISS = 0.1
"""Part by which the short-term average must fall below the long-term one to be significant."""


class FitAverages:
    """Exponential averages of how well scans fit the map, one over a long and one over a short time.

    They are those of augmented Monte Carlo localization (Thrun, Burgard, Fox, *Probabilistic Robotics*, table 8.3).
    Until 1/alpha scans have arrived, an average is their plain mean: otherwise the first scan would dominate the
    long-term average for a thousand scans.

    Parameters
    ----------
    slow, fast : float
        Weights (alpha) of the newest scan in the long-term and short-term averages; with 0, `amiss` is always False.
    """

    def __init__(self, slow: float, fast: float) -> None:
        self._alphas = np.array((slow, fast))
        self._averages = np.zeros(2)
        self._count = 0

    def note(self, fit: float) -> None:
        """Add a scan by its fit, averaged over the particles by weight."""
        self._count += 1
        parts = np.where(self._alphas > 0.0, np.maximum(self._alphas, 1.0 / self._count), 0.0)
        self._averages = self._averages + parts * (fit - self._averages)

    @property
    def amiss(self) -> bool:
        """Whether recent scans fit significantly worse than earlier ones."""
        slow, fast = self._averages
        return bool(fast < (1.0 - AMISS) * slow)

    def forget(self) -> None:
        """Start over without any scan."""
        self._averages = np.zeros(2)
        self._count = 0


class Relocalizer:
    """Notices that a robot may be lost, and provides searches of the map until it is found.

    A robot whose recent scans fit worse is suspected to be lost: the whole map is searched for it. It counts as lost
    only if it is more likely at one of the candidates found than at its estimated pose.

    Parameters
    ----------
    layers : MapLayers
    parameters : AmclParameters
    random : numpy.random.Generator
        Source of the seeds of searches.

    Attributes
    ----------
    searching : bool
        The robot may be anywhere, and was not found yet.
    """

    def __init__(self, layers: MapLayers, parameters: AmclParameters, random: np.random.Generator) -> None:
        self.searching = False
        self._suspected = False
        self._parameters = parameters
        self._random = random
        self._averages = FitAverages(parameters.recovery_alpha_slow, parameters.recovery_alpha_fast)
        self._history = ScanHistory()
        self._wanted: PoseSearch | None = None
        self._under_way: PoseSearch | None = None
        self.use_layers(layers)

    def use_layers(self, layers: MapLayers) -> None:
        """Replace the map; results of searches of the last one are discarded, and scans are judged again."""
        self.free, self._match = FreePoses(layers.grid), ScanMatch(layers, self._parameters)
        self._averages.forget()
        self._wanted = self._under_way = None

    def begin(self, *, searching: bool) -> None:
        """Start over with a robot that is lost (``searching``) or not; results of earlier searches are discarded."""
        self.searching, self._suspected = searching, False
        self._averages.forget()
        self._restart_history()

    def _restart_history(self) -> None:
        self._history.forget()
        self._wanted = self._under_way = None

    def rebase(self, jump: Pose2D) -> None:
        """Continue after a reset of the odometry; ``jump`` is the pose of the new odometry frame in the old one."""
        self._history.rebase(jump)
        self._wanted = self._under_way = None

    def note(self, fit: float, odom: Pose2D, points: NDArray[np.float64], believed: Pose2D) -> None:
        """Add a scan.

        Parameters
        ----------
        fit : float
            Fit of the scan, averaged over the particles by weight.
        odom : Pose2D
            Pose of the robot in the odometry frame.
        points : (n, 2) array
            End points of the beams in the robot's frame [m].
        believed : Pose2D
            Estimated pose of the robot in the map frame.
        """
        self._averages.note(fit)
        # A history from before would contain scans of the place that the robot has left.
        if not self.searching and self._averages.amiss != self._suspected:
            self._suspected = self._averages.amiss
            self._restart_history()
        if (self.searching or self._suspected) and len(points) and self._history.note(odom, points):
            seed = int(self._random.integers(1 << 62))
            seen, metres = self._history.seen(), self._history.metres
            self._wanted = PoseSearch(self.free, self._match, seen, metres, odom, believed, self.searching, seed)

    def next_search(self) -> PoseSearch | None:
        """Return the search to run next, once, or None; it makes the result of the search before it obsolete."""
        wanted, self._wanted = self._wanted, None
        if wanted is not None:
            self._under_way = wanted
        return wanted

    def is_current(self, found: PoseCandidates) -> bool:
        """Return whether these candidates are the result of the latest search."""
        return found.search is self._under_way

    def redraw_share(self, found: PoseCandidates) -> float:
        """Return the part of the particles to redraw from the candidates; 0 if the robot does not count as lost."""
        if not self.searching:
            self.searching = LOST / len(found.poses) > (1.0 - LOST) * found.believed_odds
        if not self.searching:
            if self._history.full:
                self.begin(searching=False)  # scans fit worse here, but no better elsewhere
            return 0.0
        odds = found.believed_odds
        return min(max(1.0 - odds / max(odds, float(found.weights[0])), LEAST_SHARE), MOST_SHARE)

    def judge(self, poses: NDArray[np.float64], weights: NDArray[np.float64], estimate: PoseEstimate) -> None:
        """End the search if the particles and the candidates agree on one pose.

        Parameters
        ----------
        poses : (n, 3) array
            Candidates, moved to the current time by odometry: x, y [m], theta [rad].
        weights : (n,) array
            Their weights with sum 1.
        estimate : PoseEstimate
            Estimate of the particles.
        """
        if estimate.share >= FOUND and weight_around(poses, weights, estimate.pose) >= FOUND:
            self.begin(searching=False)
