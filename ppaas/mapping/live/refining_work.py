"""Refining work: the search for missing loops and the joint refinement of a map, on copies, in another thread."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.closures.agreement import GRADUATED, WAITING, add_closure, divide
from ppaas.mapping.closures.closing import ClosureSearch
from ppaas.mapping.closures.closure import Closure, Links
from ppaas.mapping.closures.submaps import Submap
from ppaas.mapping.graph.pose_graph import EdgeKind, Edges, PoseGraph, balance, measured_odometry
from ppaas.mapping.graph.solver import GraphSolver
from ppaas.mapping.live.map_canvas import MapCanvas, drawn
from ppaas.mapping.map_drawing import DrawingSettings
from ppaas.mapping.parts.map_parts import WHOLE, MapParts, current_part
from ppaas.mapping.refinement import refine
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.maps.cell_rectangle import Rectangle
from ppaas.planar_poses import PoseArray, differences, relative

PASSES = 2
"""Largest number of searches of all submaps; the second one is at the poses that the first one led to."""


@dataclass(frozen=True, slots=True)
class RefinedMap:
    """Result of a refinement.

    Parameters
    ----------
    poses : (k, 3) array
        Poses of the key frames.
    renewed : (m,) int64 array
        Edges of the graph that get other measurements: closures and counterweights.
    measurements : (m, 3) array
        These measurements.
    edges : Edges
        Edges that the graph lacks: counterweights, and the closures that were missing.
    closures : int
        Number of these closures.
    waiting : list of Closure
        Closures of wide windows that wait for others to agree with.
    canvas : MapCanvas or None
        Map of these key frames at these poses; None if it would be too large.
    part : int
        Part of the map that it shows.
    """

    poses: PoseArray
    renewed: NDArray[np.int64]
    measurements: PoseArray
    edges: Edges
    closures: int
    waiting: list[Closure]
    canvas: MapCanvas | None
    part: int


@dataclass(frozen=True, slots=True)
class RefiningWork:
    """Search for closures that are missing, and joint refinement of the current part of a map.

    It changes nothing that is given, and may be run again.

    Parameters
    ----------
    mapping : Mapping
        Snapshot of the key frames, a copy of their graph, and the closures that wait.
    submaps : list of Submap
        Finished submaps that were searched for.
    search : ClosureSearch
    solver : GraphSolver
        Used by one thread at once.
    drawing : DrawingSettings
    extent : Rectangle or None
        Extent of the map, which is kept.
    parts : MapParts
        Parts of the map, of which the current one is refined.
    """

    mapping: Mapping
    submaps: list[Submap]
    search: ClosureSearch
    solver: GraphSolver
    drawing: DrawingSettings
    extent: Rectangle | None
    parts: MapParts = WHOLE

    def __call__(self, cancelled: Callable[[], bool]) -> RefinedMap | None:
        """Return the closures that were missing and the refined poses; None if the work was cancelled.

        Raises
        ------
        InvalidGraph
            The normal equations are not positive definite.
        """
        loops = _Loops(self.mapping.graph.copy(), list(self.mapping.waiting))
        for _ in range(PASSES):
            if not self._search_again(loops, cancelled):
                break
        poses = None if cancelled() else self._refined(loops.graph, cancelled)
        return None if poses is None else self._result(loops, poses)

    def _search_again(self, loops: "_Loops", cancelled: Callable[[], bool]) -> bool:
        """Search all submaps of the current part for closures that are missing; return whether any was found."""
        before = loops.closures
        for submaps in self._runs():
            links = Links(submaps, loops.graph.edges)
            for of in range(len(submaps)):
                if cancelled():
                    return False
                loops.add(self.search.search(self.mapping.frames, loops.graph, submaps, of, links).closures)
        if loops.closures == before:
            return False
        loops.graph.move_nodes(self.solver.solve(self.parts.held(loops.graph), GRADUATED).poses)
        return True

    def _result(self, loops: "_Loops", poses: PoseArray) -> RefinedMap:
        """Return the result. The graph is solved at the refined poses: the next solve keeps what they gained."""
        before, graph = self.mapping.graph, loops.graph
        _renew_closures(graph, poses)
        balance(graph, poses)
        known = graph.edges.measurements[: before.edge_count]
        renewed = np.flatnonzero((known != before.edges.measurements).any(axis=1))
        canvas = drawn(self.mapping.frames.at(poses), self.drawing, self.extent, self.parts)
        return RefinedMap(
            poses, renewed, known[renewed], graph.edges.since(before.edge_count), loops.closures,
            loops.waiting[-WAITING:], canvas, self.parts.current,
        )  # fmt: skip

    def _runs(self) -> list[list[Submap]]:
        """Return the submaps of each run of successive key frames that is in the current part."""
        within = self.parts.indices(self.parts.current, len(self.mapping.frames))
        inside = [submap for submap in self.submaps if submap.first in within]
        return self.parts.by_run(inside)

    def _refined(self, graph: PoseGraph, cancelled: Callable[[], bool]) -> PoseArray | None:
        """Return the poses of all key frames, of which the current part's are refined; None if cancelled."""
        poses = graph.poses.copy()
        part = current_part(Mapping(self.mapping.frames, graph), self.parts)
        refined = refine(part.frames, part.graph.poses, measured_odometry(part.graph.edges), cancelled=cancelled)
        if cancelled():
            return None
        poses[self.parts.indices(self.parts.current, len(poses))] = refined.poses
        return poses


class _Loops:
    """Graph to which closures are added that are missing.

    Parameters
    ----------
    graph : PoseGraph
        Modified.
    waiting : list of Closure
        Closures of wide windows that wait for others to agree with.
    """

    def __init__(self, graph: PoseGraph, waiting: list[Closure]) -> None:
        self.graph, self.waiting, self.closures = graph, waiting, 0
        closing = graph.edges.take(np.asarray(graph.edges.kinds == EdgeKind.CLOSURE))
        self._joined = set(_ends(closing))

    def add(self, found: list[Closure]) -> None:
        """Add the closures of a search that are trusted, without those that join nothing new."""
        trusted, self.waiting = divide(self.graph, found, self.waiting)
        for closure in trusted:
            if not self._joined.issuperset(_ends(closure.edges)):
                self._joined.update(_ends(closure.edges))
                add_closure(self.graph, closure)
                self.closures += 1


def _ends(edges: Edges) -> list[tuple[int, int]]:
    return list(zip(edges.first.tolist(), edges.second.tolist(), strict=True))


def _renew_closures(graph: PoseGraph, poses: PoseArray) -> None:
    """Give the closures that agree with refined poses the measurements at these."""
    edges = graph.edges
    refined = relative(poses[edges.first], poses[edges.second])
    errors = differences(refined, edges.measurements)
    chi2 = np.einsum("mi,mij,mj->m", errors, edges.information, errors)
    agreeing = np.flatnonzero((edges.kinds == EdgeKind.CLOSURE) & (chi2 <= GRADUATED.closure_chi2))
    graph.renew_measurements(agreeing, refined[agreeing])
