"""Matches: parts of the second mapping that were found in the first, each with edges that scans confirm."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.mapping.closures.branch_and_bound import (
    Blur,
    Excluded,
    LikelihoodPyramid,
    MotionWindow,
    build_pyramid,
    search,
)
from ppaas.mapping.closures.candidates import path_covariances
from ppaas.mapping.closures.check import ScanCheck
from ppaas.mapping.closures.closing import edges_of
from ppaas.mapping.closures.kernels.points import gather, thin
from ppaas.mapping.closures.parameters import DriftModel
from ppaas.mapping.closures.submaps import Submap, Submaps
from ppaas.mapping.graph.consistency import CHI2, largest_clique
from ppaas.mapping.graph.pose_graph import Edges, PoseGraph
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.merging.parameters import MergeParameters
from ppaas.planar_poses import PoseArray, compose, relative, rotated

# -- search of a whole map: coarse first, then fine --------------------------------------------------------------------

BEYOND = 5.0
"""Distance around the key frames of the map up to which places are searched [m]."""

APART, APART_TURN = 1.5, 0.3
"""Distance and angle beyond which a second place is another one than the first [m, rad]."""

NEARLY = 0.85
"""Share of the score of the best place that a second one needs."""

FINE = MotionWindow(0.6, 0.6, 0.06)
"""Window around a place of the coarse search."""


class WholeMap:
    """All points of a mapping, ready for searches.

    Parameters
    ----------
    points : (n, 2) array
        Points of all scans in the map frame [m].
    poses : (k, 3) array
        Poses of the key frames in the map frame; at least one. Places are searched around them.
    parameters : MergeParameters
    """

    def __init__(self, points: NDArray[np.float64], poses: PoseArray, parameters: MergeParameters) -> None:
        low, high = poses[:, :2].min(axis=0) - BEYOND, poses[:, :2].max(axis=0) + BEYOND
        self._middle, half = (low + high) / 2.0, (high - low) / 2.0
        self._least = parameters.least_score
        self._window = MotionWindow(float(half[0]), float(half[1]), math.pi, parameters.heading_step)
        x, y = np.abs(points - self._middle).max(axis=0, initial=0.0).tolist()
        reach = (x + 1.0, y + 1.0)
        levels = self._window.levels(parameters.resolution)
        self._coarse = self._pyramid(points, reach, parameters.resolution, levels)
        self._fine = self._pyramid(points, reach, parameters.fine_resolution, 1)

    def places(self, points: NDArray[np.float64]) -> list[tuple[Pose2D, float]]:
        """Return the best places of some points in the map, and their scores: two, one or none.

        Parameters
        ----------
        points : (n, 2) array
            Points around the origin of any frame [m].

        Returns
        -------
        list of (Pose2D, float)
            Poses of that frame in the map frame, with scores from 0 to 1, the best one first.
        """
        best = search(self._coarse, points, self._window, self._least)
        if best is None:
            return []
        apart = Excluded(best.motion, APART, APART_TURN)
        second = search(self._coarse, points, self._window, max(self._least, NEARLY * best.score), apart)
        found = (self._finer(points, match.motion) for match in (best, second) if match is not None)
        # The coarse search may find the better one second.
        return sorted((place for place in found if place is not None), key=lambda place: -place[1])

    def _finer(self, points: NDArray[np.float64], coarse: Pose2D) -> tuple[Pose2D, float] | None:
        """Return a place of the coarse search at the finer resolution, in the map frame."""
        c, s = math.cos(coarse.theta), math.sin(coarse.theta)
        turned = points @ np.array(((c, s), (-s, c)))
        shifted = replace(self._fine, corner=self._fine.corner - (coarse.x, coarse.y))
        match = search(shifted, turned, FINE)
        if match is None:
            return None
        x, y, turn = match.motion
        place = Pose2D(coarse.x + x + self._middle[0], coarse.y + y + self._middle[1], coarse.theta + turn)
        return place, match.score

    def _pyramid(
        self, points: NDArray[np.float64], reach: tuple[float, float], resolution: float, levels: int
    ) -> LikelihoodPyramid:
        return build_pyramid(points - self._middle, reach, Blur(resolution, resolution), levels)


# -- matches -----------------------------------------------------------------------------------------------------------

REACH = 20.0
"""Points of a part farther than this from its middle are left out, along each axis [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class PlaceMatch:
    """Part of the second mapping at a place of the first.

    Parameters
    ----------
    source : Submap
        Key frames of the part, as nodes of the joined graph.
    motion : Pose2D
        Frame of the second mapping in the frame of the first, as this match has it.
    score : float
        Score of the search, from 0 to 1.
    edges : Edges
        From key frames of the first mapping to key frames of the second, for each scan that passed the check.
    """

    source: Submap
    motion: Pose2D
    score: float
    edges: Edges


class PartSearch:
    """Search for parts of the second mapping in all of the first.

    Parameters
    ----------
    frames : KeyFrames
        Joined: the first mapping's, then the second's, each at their poses in the frame of their mapping.
    first : int
        Number of key frames of the first mapping.
    parameters : MergeParameters
    """

    def __init__(self, frames: KeyFrames, first: int, parameters: MergeParameters) -> None:
        self._frames, self._parameters, self._target = frames, parameters, Submap(0, first)
        points = gather(frames.points[:first], frames.valid[:first], frames.poses[:first], np.zeros(3))
        self._map = WholeMap(points, frames.poses[:first], parameters)
        self._check = ScanCheck(frames, frames.poses, parameters.closures)

    def parts(self) -> list[Submap]:
        """Return the parts, which overlap each other, in the order of the drive."""
        step, poses = self._parameters.part_step / 2.0, self._frames.poses
        short = Submaps(step)
        for node in range(self._target.end, len(poses)):
            known = node > self._target.end
            short.add(relative(poses[node - 1], poses[node]) if known else np.zeros(3))
        short.finish()
        ends, count = short.finished, max(round(self._parameters.part_travel / step), 1)
        starts = range(0, max(len(ends) - count, 0) + 1, 2)
        first = self._target.end
        return [Submap(first + ends[at].first, first + ends[min(at + count, len(ends)) - 1].end) for at in starts]

    def search(self, part: Submap) -> list[PlaceMatch]:
        """Return the places of the first mapping at which a part fits: two, one or none."""
        chosen = slice(part.first, part.end)
        poses = self._frames.poses[chosen]
        middle = Pose2D(*poses[:, :2].mean(axis=0).tolist())
        points = gather(self._frames.points[chosen], self._frames.valid[chosen], poses, np.array(middle))
        found = []
        for place, score in self._map.places(thin(points, self._parameters.thin, REACH)):
            motion = place @ middle.inverse()
            passed = self._check.run(part, self._target, compose(np.array(motion), poses))
            if len(passed) >= self._parameters.closures.loop_match_minimum_chain_size:
                found.append(PlaceMatch(part, motion, score, edges_of(passed)))
        return found


# -- sets of matches that the drift along both mappings explains -------------------------------------------------------

FLOOR = (0.15, 0.15, 0.03)
"""Standard deviations of the difference of two matches without any drift [m, m, rad]."""


def agreeing_sets(graph: PoseGraph, matches: Sequence[PlaceMatch], drift: DriftModel) -> Iterator[list[PlaceMatch]]:
    """Yield disjoint sets of matches that agree pairwise: the largest, the largest of the others, and so on.

    Parameters
    ----------
    graph : PoseGraph
        Nodes and edges of both mappings, each in its own frame; no edge connects them.
    matches : sequence of PlaceMatch
    drift : DriftModel
        Growth of the uncertainty with the distance travelled.
    """
    agree = pairwise_chi2(graph, matches, drift) <= CHI2
    remaining = np.arange(len(matches))
    while remaining.size:
        chosen = remaining[largest_clique(agree[np.ix_(remaining, remaining)])]
        yield [matches[k] for k in chosen]
        remaining = np.setdiff1d(remaining, chosen)


def pairwise_chi2(graph: PoseGraph, matches: Sequence[PlaceMatch], drift: DriftModel) -> NDArray[np.float64]:
    """Return the squared Mahalanobis distances (m, m) of every two matches.

    Two matches place one key frame differently. The covariance of that difference is the covariance of the paths
    between the matches, along the one mapping and along the other. Two matches of one part of the drive at different
    places thus never agree. Parameters are the same as for `agreeing_sets`.
    """
    count = len(matches)
    sources = np.array([_middle(match.edges.second) for match in matches], np.int64)
    targets = np.array([_middle(match.edges.first) for match in matches], np.int64)
    motions = np.array([tuple(match.motion) for match in matches]).reshape(count, 3)
    distances = np.zeros((count, count))
    for k in range(count):
        along_second, _ = path_covariances(graph.poses, graph.edges, int(sources[k]), drift)
        along_first, _ = path_covariances(graph.poses, graph.edges, int(targets[k]), drift)
        placed = compose(motions, graph.poses[sources[k]])
        apart = placed - placed[k]
        apart[:, 2] = relative(placed[k], placed)[:, 2]
        total = along_first[targets] + rotated(along_second[sources], motions[:, 2]) + np.diag(np.square(FLOOR))
        distances[k] = _squared(apart, total)
    return np.maximum(distances, distances.T)


def _squared(errors: NDArray[np.float64], covariances: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return squared Mahalanobis distances (m,); 0 where no path gives a covariance."""
    known = np.isfinite(covariances).all(axis=(1, 2))
    found = np.zeros(len(errors))
    solved = np.linalg.solve(covariances[known], errors[known][:, :, None])[:, :, 0]
    found[known] = np.einsum("mi,mi->m", errors[known], solved)
    return found


def _middle(nodes: NDArray[np.int64]) -> int:
    return int(nodes[len(nodes) // 2])
