"""Whether a robot is lost, and what is looked for then."""

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.map_layers import MapLayers
from ppaas.geometry import Pose2D
from ppaas.localization.fit_averages import FitAverages
from ppaas.localization.free_poses import FreePoses
from ppaas.localization.parameters import AmclParameters
from ppaas.localization.pose_estimate import PoseEstimate, weight_around
from ppaas.localization.pose_search import Found, Search
from ppaas.localization.scan_history import History
from ppaas.localization.scan_match import Match

FOUND = 0.8
"""Part of the weight at one place that ends the search: of the particles, and of all that was found."""


LOST = 0.1
"""How likely a robot is lost whose scans fit worse of late, before anything is looked for."""

LEAST_SHARE, MOST_SHARE = 0.05, 0.9
"""Part of the particles that are drawn anew for a robot that is lost, at least and at most."""


class Seeker:
    """Says where in the map to look, for as long as a robot may be anywhere, and keeps what is needed for that.

    A robot whose scans fit worse of late is suspected to be lost: all over the map is looked for where it could be, but
    it counts as lost only where it is more likely in one of those places than where it is taken to be.

    Parameters
    ----------
    layers : MapLayers
    parameters : AmclParameters
    random : numpy.random.Generator
        Seeds searches.

    Attributes
    ----------
    searching : bool
        The robot may be anywhere, and was not found yet.
    """

    def __init__(self, layers: MapLayers, parameters: AmclParameters, random: np.random.Generator) -> None:
        self.free = FreePoses(layers.grid)
        self.searching = False
        self._suspected = False
        self._match = Match(layers, parameters)
        self._random = random
        self._averages = FitAverages(parameters.recovery_alpha_slow, parameters.recovery_alpha_fast)
        self._history = History()
        self._wanted: Search | None = None
        self._under_way: Search | None = None

    def begin(self, *, searching: bool) -> None:
        """Forget all, and take the robot for lost or not; what is found of what was looked for before is no use."""
        self.searching, self._suspected = searching, False
        self._averages.forget()
        self._look_anew()

    def _look_anew(self) -> None:
        self._history.forget()
        self._wanted = self._under_way = None

    def rebase(self, jump: Pose2D) -> None:
        """Take note that odometry began anew; ``jump`` is the pose of its new frame in the one before."""
        self._history.rebase(jump)
        self._wanted = self._under_way = None

    def note(self, fit: float, odom: Pose2D, points: NDArray[np.float64], told: Pose2D) -> None:
        """Take note of a scan.

        Parameters
        ----------
        fit : float
            How well it fits, weighed over the particles.
        odom : Pose2D
            Of the robot in the odometry frame.
        points : (n, 2) array
            Where its beams ended, in the robot's frame [m].
        told : Pose2D
            Where the robot is taken to be.
        """
        self._averages.note(fit)
        if not self.searching and self._averages.amiss != self._suspected:
            self._suspected = self._averages.amiss
            self._look_anew()
        if (self.searching or self._suspected) and len(points) and self._history.note(odom, points):
            seed = int(self._random.integers(1 << 62))
            seen, metres = self._history.seen(), self._history.metres
            self._wanted = Search(self.free, self._match, seen, metres, odom, told, self.searching, seed)

    def next_search(self) -> Search | None:
        """Return what to look for now, once, or None; what is found of what was returned before is no use then."""
        wanted, self._wanted = self._wanted, None
        if wanted is not None:
            self._under_way = wanted
        return wanted

    def is_current(self, found: Found) -> bool:
        """Tell whether that was looked for last."""
        return found.search is self._under_way

    def share_anew(self, found: Found) -> float:
        """Return which part of the particles is to be drawn where the robot may be."""
        if not self.searching:
            self.searching = LOST / len(found.poses) > (1.0 - LOST) * found.told
        if not self.searching:
            if self._history.full:
                self.begin(searching=False)  # scans fit worse here, and nowhere better
            return 0.0
        return min(max(1.0 - found.told / max(found.told, float(found.weights[0])), LEAST_SHARE), MOST_SHARE)

    def judge(self, poses: NDArray[np.float64], weights: NDArray[np.float64], estimate: PoseEstimate) -> None:
        """End the search where the particles and what was found agree on one place.

        Parameters
        ----------
        poses : (n, 3) array
            That were found, where the robot would be now in each case: x, y [m], theta [rad].
        weights : (n,) array
            Sum 1.
        estimate : PoseEstimate
            Of the particles.
        """
        if estimate.share >= FOUND and weight_around(poses, weights, estimate.pose) >= FOUND:
            self.begin(searching=False)
