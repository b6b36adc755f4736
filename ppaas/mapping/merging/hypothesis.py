"""Hypotheses: poses of both mappings in one frame by matches that agree, and how far the scans overlap there."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D, wrap_angle
from ppaas.mapping.alignment import align
from ppaas.mapping.closures.check import ALIGNED_WITH, MOST_MOVED, MOST_TURNED, CheckedScan
from ppaas.mapping.closures.closing import edges_of
from ppaas.mapping.graph.pose_graph import EdgeKind, Edges, PoseGraph
from ppaas.mapping.graph.solver import GraphSolver, Robust, SolverOptions
from ppaas.mapping.key_frame_graph import weakest_information
from ppaas.mapping.key_frames import KeyFrames, NearFrames
from ppaas.mapping.merging.matches import PlaceMatch
from ppaas.mapping.merging.parameters import MergeParameters
from ppaas.mapping.near_poses import nearest_poses
from ppaas.mapping.visible_points import confirmed_share
from ppaas.planar_poses import PoseArray, compose, relative

# -- overlap at given poses --------------------------------------------------------------------------------------------

NEAR = 1.5
"""Largest distance between a scan and the key frames that it is compared with; see `nearest_poses` [m]."""

MOST = 200
"""Largest number of scans that are compared."""


class Overlap(NamedTuple):
    """Comparison of the scans of the second mapping that were taken near key frames of the first.

    Parameters
    ----------
    nodes : (n,) int64 array
        Key frames of the second mapping that were compared.
    fits : (n,) bool array
        Whether each can be aligned with the first's.
    confirmed : (n,) float64 array
        Share of the points visible to both lasers that both confirm, at the aligned pose; 0 of those that do not fit.
    scans : list of CheckedScan
        Scans that passed, and whose position is determined in every direction: they can be edges.
    """

    nodes: NDArray[np.int64]
    fits: NDArray[np.bool_]
    confirmed: NDArray[np.float64]
    scans: list[CheckedScan]


def compare(frames: KeyFrames, poses: PoseArray, first: int, parameters: MergeParameters) -> Overlap:
    """Compare the scans of the second mapping with the first's.

    Parameters
    ----------
    frames : KeyFrames
        Joined: the first mapping's, then the second's.
    poses : (k, 3) array
        Their poses in one frame.
    first : int
        Number of key frames of the first mapping.
    parameters : MergeParameters
    """
    near = nearest_poses(poses[first:], poses[:first], ALIGNED_WITH, NEAR)
    candidates = np.flatnonzero(near[:, 0] >= 0)
    chosen = candidates[:: max(1, -(-len(candidates) // MOST))]
    fits, confirmed, scans = np.zeros(len(chosen), np.bool_), np.zeros(len(chosen)), []
    for row, at in enumerate(chosen):
        others = near[at][near[at] >= 0]
        scan = _checked(frames, first + int(at), poses, others, parameters)
        if scan is None:
            continue
        fits[row], confirmed[row] = True, scan.confirmed
        closures = parameters.closures
        determined = weakest_information(scan.information) >= closures.least_information
        if determined and scan.confirmed >= closures.least_confirmed:
            scans.append(scan)
    return Overlap(first + chosen, fits, confirmed, scans)


def _checked(
    frames: KeyFrames, node: int, poses: PoseArray, others: NDArray[np.int64], parameters: MergeParameters
) -> CheckedScan | None:
    """Return a scan aligned with key frames of the first mapping; None if it does not fit."""
    near, start = NearFrames(others, poses[others]), Pose2D(*poses[node].tolist())
    scan = frames.scan_points(node)
    found = align(scan, start, frames, near)
    if found.ratio < parameters.closures.least_ratio or start.distance_to(found.pose) > MOST_MOVED:
        return None
    if abs(wrap_angle(found.pose.theta - start.theta)) > MOST_TURNED:
        return None
    confirmed = confirmed_share(frames, scan, near, found.pose, parameters.tolerance)
    measurement = relative(near.poses[0], np.array(found.pose))
    return CheckedScan(node, int(others[0]), measurement, found.information, found.ratio, confirmed)


# -- hypotheses --------------------------------------------------------------------------------------------------------

ROUNDS = 2
"""Number of times that scans are compared and the graph is solved with the edges found."""

FIRST = SolverOptions(Robust.GRADUATED, iterations=60)
"""Options of the first solve: the second mapping is off by its drift."""

NEXT = SolverOptions(Robust.SCALING, iterations=20)
"""Options of the solves with more edges."""


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """Poses of both mappings in the frame of the first.

    Parameters
    ----------
    matches : list of PlaceMatch
        Matches that it is based on.
    graph : PoseGraph
        Nodes and edges of both mappings, solved with the closures between them.
    overlap : Overlap
        Comparison at these poses.
    """

    matches: list[PlaceMatch]
    graph: PoseGraph
    overlap: Overlap

    @property
    def support(self) -> float:
        """Share of the compared scans that fit; 0 without any."""
        return float(self.overlap.fits.mean()) if len(self.overlap.fits) else 0.0

    @property
    def confirmed(self) -> float:
        """Mean share of the confirmed points of the scans that fit; 0 without any."""
        fits = self.overlap.fits
        return float(self.overlap.confirmed[fits].mean()) if fits.any() else 0.0


def joined_graph(first: PoseGraph, second: PoseGraph) -> PoseGraph:
    """Return a graph with the nodes and edges of two graphs, the first one's before the second's."""
    shift = first.node_count
    moved = second.edges._replace(first=second.edges.first + shift, second=second.edges.second + shift)
    edges = stacked((first.edges, moved))
    return PoseGraph.of(np.concatenate((first.poses, second.poses)), edges)


def stacked(edges: Sequence[Edges]) -> Edges:
    """Return the edges of several sets, one after the other."""
    return Edges(*map(np.concatenate, zip(*edges, strict=True)))


def hypothesis(
    frames: KeyFrames, graph: PoseGraph, first: int, matches: list[PlaceMatch], parameters: MergeParameters
) -> Hypothesis:
    """Return the poses that a set of matches leads to.

    Parameters
    ----------
    frames : KeyFrames
        Joined key frames.
    graph : PoseGraph
        Joined graph; left unchanged.
    first : int
        Number of key frames of the first mapping.
    matches : list of PlaceMatch
        At least one.
    parameters : MergeParameters
    """
    solver, poses = GraphSolver(), graph.poses.copy()
    best = max(matches, key=lambda match: match.score)
    poses[first:] = compose(np.array(best.motion), poses[first:])
    graph = graph.copy()
    graph.move_nodes(poses)
    edges = stacked([match.edges for match in matches])
    solved = _solved(solver, graph, edges, FIRST)
    for _ in range(ROUNDS):
        overlap = compare(frames, solved.poses, first, parameters)
        if not overlap.scans:
            break
        graph.move_nodes(solved.poses)
        solved = _solved(solver, graph, edges_of(overlap.scans), NEXT)
    return Hypothesis(matches, solved, overlap)


def _solved(solver: GraphSolver, graph: PoseGraph, closures: Edges, options: SolverOptions) -> PoseGraph:
    joined = graph.copy()
    for first, second, measurement, information in zip(*closures[:4], strict=True):
        joined.add_edge(int(first), int(second), measurement, information, EdgeKind.CLOSURE)
    joined.move_nodes(solver.solve(joined, options).poses)
    return joined
