"""Hypotheses: poses of both mappings in one frame, by a set of matches that agree."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ppaas.mapping.closures.closing import edges_of
from ppaas.mapping.graph.pose_graph import EdgeKind, Edges, PoseGraph
from ppaas.mapping.graph.solver import GraphSolver, Robust, SolverOptions
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.merging.matches import PlaceMatch
from ppaas.mapping.merging.overlap import Overlap, compare
from ppaas.mapping.merging.parameters import MergeParameters
from ppaas.planar_poses import compose

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
    """Return a solved copy of a graph with more closures."""
    joined = graph.copy()
    for first, second, measurement, information in zip(*closures[:4], strict=True):
        joined.add_edge(int(first), int(second), measurement, information, EdgeKind.CLOSURE)
    joined.move_nodes(solver.solve(joined, options).poses)
    return joined
