"""Search for the loop closures of a submap, and what contradicts itself among them."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D, wrap_angle
from ppaas.mapping.closures.branch_and_bound import (
    Blur,
    Excluded,
    LikelihoodPyramid,
    Match,
    MotionWindow,
    build_pyramid,
    search,
)
from ppaas.mapping.closures.candidates import SubmapCandidate, find_candidates, path_covariances, search_window
from ppaas.mapping.closures.check import CheckedScan, ScanCheck
from ppaas.mapping.closures.closure import Closure, Links, Reason, RefusedClosure, Searched
from ppaas.mapping.closures.kernels.points import gather, thin
from ppaas.mapping.closures.parameters import ClosureParameters
from ppaas.mapping.closures.submaps import Submap
from ppaas.mapping.graph.pose_graph import EdgeKind, Edges, PoseGraph
from ppaas.mapping.key_frame_graph import CLOSURE_FLOOR, edge_information
from ppaas.mapping.key_frames import KeyFrames
from ppaas.planar_poses import compose

# -- closures that put a submap at different places, as in corridors with equal doors ----------------------------------

Found = Closure | RefusedClosure

SAME_TURN = 0.1
"""Difference of headings up to which two closures agree in any case [rad]."""


class ClosureComparison:
    """Comparison of closures of one submap.

    Parameters
    ----------
    poses : (n, 3) array
        Poses of the key frames.
    edges : Edges
        Edges of the pose graph.
    parameters : ClosureParameters
    """

    def __init__(self, poses: NDArray[np.float64], edges: Edges, parameters: ClosureParameters) -> None:
        self._poses, self._edges, self._parameters = poses, edges, parameters

    def with_best(self, best: Closure, others: Iterable[Found]) -> Iterator[Found]:
        """Yield the matches that put the submap at a place which drift between the older submaps does not explain.

        Parameters
        ----------
        best : Closure
            Closure with the largest score.
        others : iterable of Closure and RefusedClosure
        """
        covariances = None
        for other in others:
            if other.motion is None:
                continue
            apart = self._difference(best, other.motion)
            if math.hypot(apart.x, apart.y) < self._parameters.ambiguous_distance and abs(apart.theta) < SAME_TURN:
                continue
            if covariances is None:
                model = self._parameters.drift
                covariances, _ = path_covariances(self._poses, self._edges, best.target.middle, model)
            if not self._explains(covariances[other.target.middle], apart):
                yield other

    def _difference(self, best: Closure, motion: Pose2D) -> Pose2D:
        """Return the difference of the poses of one key frame by two matches, in the axes of the map."""
        pose = Pose2D(*self._poses[best.source.middle].tolist())
        one, two = best.motion @ pose, motion @ pose
        return Pose2D(two.x - one.x, two.y - one.y, wrap_angle(two.theta - one.theta))

    def _explains(self, covariance: NDArray[np.float64], apart: Pose2D) -> bool:
        (x, y, turn), angle = search_window(covariance, self._parameters)
        c, s = math.cos(angle), math.sin(angle)
        along, across = c * apart.x + s * apart.y, c * apart.y - s * apart.x
        return abs(along) <= x and abs(across) <= y and abs(apart.theta) <= turn


# -- the search --------------------------------------------------------------------------------------------------------

REACH = 20.0
"""Points of the latest submap farther than this from its middle are left out, along each axis [m]."""

THIN, THIN_WIDE = 0.15, 0.2
"""Size of the cells of which one point is kept, in narrow and in wide windows [m]."""

FULL_SCORE_WINDOW, MORE_SCORE = 5.0, 0.1
"""Half size of a window that needs the full addition to the least score [m], and that addition."""

WIDE_STRIDE = 3
"""Targets of wide windows overlap, so that every third is enough."""

MORE_WIDE = 3
"""Factor of the number of candidates if most windows are wide."""


class Rivalry(NamedTuple):
    """Bounds above which a motion is a rival of the best one.

    Parameters
    ----------
    share : float
        Share of the best score.
    distance : float
        Translations nearer to the best one belong to the same optimum [m] …
    turn : float
        … if their rotations differ by at most this [rad].
    """

    share: float = 0.92
    distance: float = 1.0
    turn: float = 0.3


def rival_match(
    pyramid: LikelihoodPyramid,
    points: NDArray[np.float64],
    window: MotionWindow,
    best: Match,
    least: Rivalry,
) -> Match | None:
    """Return the best motion away from the best one, or None if none comes near its score.

    Along a corridor, or in rooms that look alike, another motion fits nearly as well.

    Parameters
    ----------
    pyramid, points, window
        As in the search that found ``best``.
    best : Match
        Best motion.
    least : Rivalry
    """
    return search(pyramid, points, window, least.share * best.score, Excluded(best.motion, least.distance, least.turn))


@dataclass(frozen=True, slots=True)
class _Pair:
    """Key frames to match, and the window to match them in."""

    source: Submap
    target: Submap
    candidate: SubmapCandidate


class ClosureSearch:
    """Search for loop closures.

    Parameters
    ----------
    parameters : ClosureParameters, optional
    """

    def __init__(self, parameters: ClosureParameters | None = None) -> None:
        self._parameters = parameters = parameters or ClosureParameters()
        self._rivalry = Rivalry(parameters.ambiguous_share, parameters.ambiguous_distance)
        self._blur = Blur(parameters.loop_search_space_resolution, parameters.loop_search_space_smear_deviation)

    def search(
        self, frames: KeyFrames, graph: PoseGraph, submaps: list[Submap], of: int, links: Links | None = None
    ) -> Searched:
        """Return the closures between a submap and older ones.

        Parameters
        ----------
        frames : KeyFrames
            Scans of the key frames; their poses are taken from the graph.
        graph : PoseGraph
            One node per key frame.
        submaps : list of Submap
            Finished submaps.
        of : int
            Index of the submap to search for.
        links : Links, optional
            Closures of an earlier search, at the poses of which a second one looks for those that are missing: with
            every pass of the place that is not joined with the submap, a longer part of which is matched.
        """
        poses, edges, result = graph.poses, graph.edges, Searched()
        for pair in self._pairs(poses, edges, submaps, of, links):
            found = self._match(frames, poses, pair)
            if isinstance(found, Closure):
                result.closures.append(found)
            else:
                result.refusals.append(found)
        return self._settled(result, ClosureComparison(poses, edges, self._parameters))

    def _settled(self, searched: Searched, contradictions: ClosureComparison) -> Searched:
        """Return the closures that do not contradict the best one; none if a match elsewhere is nearly as good."""
        if not searched.closures:
            return searched
        best = max(searched.closures, key=lambda closure: closure.score)
        rivals = list(contradictions.with_best(best, [*searched.closures, *searched.refusals]))
        # A match elsewhere that is nearly as good means that the place looks like another: trust neither.
        if any(rival.score > self._parameters.ambiguous_share * best.score for rival in rivals):
            refused = [closure.refused(Reason.AMBIGUOUS) for closure in searched.closures]
            return Searched([], searched.refusals + refused)
        refused = [rival.refused(Reason.CONTRADICTED) for rival in rivals if isinstance(rival, Closure)]
        kept = [closure for closure in searched.closures if closure not in rivals]
        return Searched(kept, searched.refusals + refused)

    def _pairs(
        self, poses: NDArray[np.float64], edges: Edges, submaps: list[Submap], of: int, links: Links | None
    ) -> list[_Pair]:
        """Return the pairs to match, the most probable first."""
        parameters = self._parameters
        candidates = find_candidates(poses, edges, submaps, of, parameters)
        most = parameters.candidates
        if links is not None:
            candidates = links.unlinked(of, candidates)
        elif sum(candidate.wide for candidate in candidates) > len(candidates) / 2:
            # Wide windows are matched for every third target only, so more candidates take as long.
            most *= MORE_WIDE
        pairs = (self._pair(candidate, submaps, of, again=links is not None) for candidate in candidates[:most])
        return [pair for pair in pairs if pair is not None]

    def _pair(self, candidate: SubmapCandidate, submaps: list[Submap], of: int, *, again: bool) -> _Pair | None:
        """Return the key frames to match for a candidate; None where its neighbour covers it."""
        between, at = self._parameters.fewest_submaps_between, candidate.target
        side = self._parameters.wide_submaps if candidate.wide or again else 1
        if not candidate.wide:
            last = min(at + side, of - between - 1)
            return _Pair(submaps[of], Submap(submaps[max(0, at - side)].first, submaps[last].end), candidate)
        if (at % WIDE_STRIDE and not again) or at > of - 2 * between - 2:
            return None
        source = Submap(submaps[max(0, of - 2)].first, submaps[of].end)
        last = min(at + side, of - 2 - between - 1)
        return _Pair(source, Submap(submaps[max(0, at - side)].first, submaps[last].end), candidate)

    def _match(self, frames: KeyFrames, poses: NDArray[np.float64], pair: _Pair) -> Closure | RefusedClosure:
        """Return the closure of a pair, or why there is none."""
        parameters, window = self._parameters, pair.candidate.window
        points = self._points(frames, poses, pair)
        pyramid = self._pyramid(frames, poses, pair)
        share = min(1.0, window.x / FULL_SCORE_WINDOW)
        best = search(pyramid, points, window, parameters.loop_match_minimum_response_coarse + MORE_SCORE * share)
        if best is None:
            return RefusedClosure(pair.source, pair.target, Reason.SCORE, 0.0)
        frame = pair.candidate.frame
        motion = frame @ best.motion @ frame.inverse()
        if pair.candidate.wide and self._is_ambiguous(pyramid, points, pair, best):
            return RefusedClosure(pair.source, pair.target, Reason.AMBIGUOUS, best.score, motion)
        moved = compose(np.array(motion), poses[pair.source.first : pair.source.end])
        # A narrow window bounds the position along a corridor, so scans may leave it open.
        slides = not pair.candidate.wide
        passed = ScanCheck(frames, poses, parameters).run(pair.source, pair.target, moved, slides=slides)
        if len(passed) < parameters.loop_match_minimum_chain_size:
            return RefusedClosure(pair.source, pair.target, Reason.CHECK, best.score, motion)
        return Closure(pair.source, pair.target, edges_of(passed), best.score, motion, pair.candidate.wide)

    def _is_ambiguous(self, pyramid: LikelihoodPyramid, points: NDArray[np.float64], pair: _Pair, best: Match) -> bool:
        """Return whether another motion fits nearly as well as the best one."""
        return rival_match(pyramid, points, pair.candidate.window, best, self._rivalry) is not None

    def _points(self, frames: KeyFrames, poses: NDArray[np.float64], pair: _Pair) -> NDArray[np.float64]:
        """Return the thinned points of the latest key frames in the frame of the search."""
        size = THIN_WIDE if pair.candidate.wide else THIN
        return thin(_gathered(frames, poses, pair.source, pair.candidate.frame), size, REACH)

    def _pyramid(self, frames: KeyFrames, poses: NDArray[np.float64], pair: _Pair) -> LikelihoodPyramid:
        """Return the pyramid of the older key frames in the frame of the search."""
        window = pair.candidate.window
        points = _gathered(frames, poses, pair.target, pair.candidate.frame)
        beyond = REACH * np.sqrt(2.0)
        reach = (window.x + beyond, window.y + beyond)
        return build_pyramid(points, reach, self._blur, window.levels(self._blur.resolution))


def _gathered(frames: KeyFrames, poses: NDArray[np.float64], submap: Submap, frame: Pose2D) -> NDArray[np.float64]:
    """Return the points of a submap's key frames in a frame of the map."""
    chosen = slice(submap.first, submap.end)
    found: NDArray[np.float64] = gather(frames.points[chosen], frames.valid[chosen], poses[chosen], np.array(frame))
    return found


def edges_of(scans: list[CheckedScan]) -> Edges:
    """Return the edges of scans that passed the check, from the older key frames to the later ones."""
    measurements = np.array([scan.measurement for scan in scans])
    information = np.array([scan.information for scan in scans])
    return Edges(
        np.array([scan.target for scan in scans]),
        np.array([scan.source for scan in scans]),
        measurements,
        edge_information(measurements, information, CLOSURE_FLOOR),
        np.full(len(scans), EdgeKind.CLOSURE, np.uint8),
    )
