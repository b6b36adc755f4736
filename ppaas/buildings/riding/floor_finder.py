"""Finds floor and pose of a robot that leaves a lift, by its first scans, on the maps of all floors it may be on.

On each floor the robot is expected where the car is; its scans are aligned with the map there, and the fits tell the
floors apart. Where no map fits, the robot is looked for in the whole lobby.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ppaas.buildings.riding.floor_belief import FloorBelief
from ppaas.costmap.map_layers import MapLayers
from ppaas.geometry import Pose2D
from ppaas.localization.beams import choose_beams
from ppaas.localization.parameters import AmclParameters
from ppaas.localization.scan_match import ScanMatch, align

BEAMS = 90
"""Beams of a scan that are compared with a map."""

EVIDENCE = 0.25
"""Part of the beams of a scan that count as independent evidence between floors: people and moved furniture cover
several beams at once."""

LOOK, TURN = 0.1, 0.1
"""Motion after which a scan is taken to be independent of the one before [m, rad]."""

STILL = 3
"""Number of scans of a robot that stands still that count."""

SPREAD = np.array((0.3, 0.3, 0.15))
"""Standard deviations of the pose in the car when the robot leaves it [m, m, rad]."""

PER_METRE = np.array((0.05, 0.05, 0.05))
"""What a metre of odometry adds to them."""

LEAST = np.array((0.02, 0.02, 0.01))

GOOD = 0.5
"""Fit from which on a scan is taken to show the map; below it on all floors, the lobby is searched."""

LOBBY = 6.0
"""Distance from the expected pose in which the lobby is searched [m]."""

POSES, ROUNDS = 3000, ((0.25, 0.15), (0.08, 0.05))
"""Number of poses with which a lobby is searched, and the random steps that improve the best of them [m, rad]."""

KEPT = 60


@dataclass(slots=True)
class _Candidate:
    layers: MapLayers
    match: ScanMatch
    pose: Pose2D
    spread: NDArray[np.float64] = field(default_factory=SPREAD.copy)
    fit: float = 0.0


class FloorFinder:
    """Finds floor and pose of one robot.

    Parameters
    ----------
    belief : FloorBelief
        What is known of the floor; scans add to it.
    floors : mapping of str to (MapLayers, Pose2D)
        Map of each floor that the robot may be on, and its pose there if the lift stands on that floor.
    odom : Pose2D
        Odometry of the robot at these poses.
    parameters : AmclParameters

    Attributes
    ----------
    looks : int
        Number of scans that have added to the belief.
    """

    def __init__(
        self,
        belief: FloorBelief,
        floors: Mapping[str, tuple[MapLayers, Pose2D]],
        odom: Pose2D,
        parameters: AmclParameters,
    ) -> None:
        self.belief = belief
        self._odom, self._counted = odom, None if not floors else odom
        self._still = self.looks = 0
        self._random = np.random.default_rng(0)
        self._candidates = {
            floor: _Candidate(layers, ScanMatch(layers, parameters), pose) for floor, (layers, pose) in floors.items()
        }

    def scan(self, points: NDArray[np.float64], odom: Pose2D) -> None:
        """Take a scan: (n, 2) ends of beams in the frame of the robot, maybe none, and its odometry."""
        motion = self._odom.inverse() @ odom
        self._odom = odom
        driven = float(np.hypot(motion.x, motion.y))
        for each in self._candidates.values():
            each.pose = each.pose @ motion
            each.spread = each.spread + PER_METRE * driven
        if len(points) == 0:
            return
        beams = choose_beams(points, BEAMS)
        for each in self._candidates.values():
            self._align(each, beams)
        if all(each.fit < GOOD for each in self._candidates.values()):
            self._search(beams)
        if self._counts(odom):
            self.looks += 1
            weight = EVIDENCE * len(beams)
            self.belief.scan({floor: weight * each.fit for floor, each in self._candidates.items()})

    def _align(self, candidate: _Candidate, beams: NDArray[np.float64]) -> None:
        found = align(candidate.match, beams, candidate.pose, candidate.spread)
        candidate.fit = found.fit
        if found.fit >= GOOD:
            candidate.pose = found.pose
            candidate.spread = np.maximum(np.sqrt(np.diag(found.covariance)), LEAST)

    def _search(self, beams: NDArray[np.float64]) -> None:
        """Look for the robot in the lobby of each floor; a candidate moves where a pose fits well."""
        for each in self._candidates.values():
            reach = np.array((LOBBY, LOBBY, np.pi))
            poses = np.array(each.pose) + self._random.uniform(-1.0, 1.0, (POSES, 3)) * reach
            poses = poses[np.argsort(-each.match.fits(poses, beams, 3.0))[:KEPT]]
            for step, turn in ROUNDS:
                tried = np.repeat(poses, 12, axis=0)
                tried += self._random.standard_normal(tried.shape) * (step, step, turn)
                poses = tried[np.argsort(-each.match.fits(tried, beams, 1.5))[:KEPT]]
            found = align(each.match, beams, Pose2D(*poses[0].tolist()), ROUNDS[-1][0] * np.array((1.0, 1.0, 0.5)))
            if found.fit >= GOOD:
                each.pose, each.fit = found.pose, found.fit
                each.spread = np.maximum(np.sqrt(np.diag(found.covariance)), LEAST)

    def _counts(self, odom: Pose2D) -> bool:
        """Return whether a scan is independent of those before, or one of the first of a robot that stands."""
        motion = Pose2D(0.0, 0.0) if self._counted is None else self._counted.inverse() @ odom
        if np.hypot(motion.x, motion.y) >= LOOK or abs(motion.theta) >= TURN:
            self._counted, self._still = odom, 0
            return True
        self._still += 1
        return self._still <= STILL

    def on(self, floor: str) -> tuple[Pose2D, bool]:
        """Return the likeliest pose on the map of a floor, and whether the last scan fits there."""
        candidate = self._candidates[floor]
        return candidate.pose, candidate.fit >= GOOD

    @property
    def found(self) -> tuple[str, Pose2D] | None:
        """Floor and pose of the robot; None while the floor is not known, or no pose on it fits."""
        floor = self.belief.known
        candidate = None if floor is None else self._candidates.get(floor)
        if floor is None or candidate is None or candidate.fit < GOOD:
            return None
        return floor, candidate.pose
