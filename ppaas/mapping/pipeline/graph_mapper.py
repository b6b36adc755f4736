"""Graph mapper: tracks scans, finds loop closures, and keeps the pose graph of the key frames solved."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ppaas.clock import monotonic
from ppaas.geometry import Pose2D
from ppaas.mapping.closures.agreement import add_closure, agreeing_closures
from ppaas.mapping.closures.closing import ClosureSearch
from ppaas.mapping.closures.closure import Closure, Searched
from ppaas.mapping.closures.parameters import ClosureParameters
from ppaas.mapping.closures.submaps import Submaps
from ppaas.mapping.edge_information import STEP_FLOOR, edge_information
from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph
from ppaas.mapping.graph.solver import GraphSolver, Robust, Solution, SolverOptions
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.laser_geometry import LaserGeometry
from ppaas.mapping.parameters import SlamParameters
from ppaas.mapping.scan_points import ScanPoints
from ppaas.mapping.scan_tracker import ScanTracker, Tracked
from ppaas.planar_poses import relative

FRONT_END, CLOSURES = SlamParameters(), ClosureParameters()
"""Default parameters."""

CLOSING = SolverOptions(Robust.SCALING, iterations=6)
"""Options of the solve after closures were found; poses are near the solution, since few edges are new."""

FINAL = SolverOptions(Robust.GRADUATED, iterations=60)
"""Options of the last solve, in which closures that contradict the others lose all weight."""

TRUSTED = 0.3
"""Least weight of a closure that counts as part of the map; one with less contradicts the others."""

PENDING = 40
"""Largest number of closures that wait for others; the oldest are given up."""

Result = TypeVar("Result")


@dataclass(slots=True)
class ClosureCounts:
    """Numbers of searches and closures.

    Parameters
    ----------
    submaps : int
        Submaps that were searched for.
    refused : dict of str to int
        Candidates that were refused, by reason.
    closures, edges : int
        Closures that entered the graph, and their edges.
    lone : int
        Closures of wide windows that no other closure agreed with.
    distrusted : int
        Edges of closures that contradict the others and do not count in the map.
    """

    submaps: int = 0
    refused: dict[str, int] = field(default_factory=dict)
    closures: int = 0
    edges: int = 0
    lone: int = 0
    distrusted: int = 0

    def add(self, searched: Searched) -> None:
        """Count the refusals of a search."""
        self.submaps += 1
        for refusal in searched.refusals:
            name = refusal.reason.name.lower()
            self.refused[name] = self.refused.get(name, 0) + 1


class GraphMapper:
    """Maps scan by scan.

    Parameters
    ----------
    geometry : LaserGeometry
    parameters : SlamParameters
        Of the front end.
    closures : ClosureParameters
        Of the search for loop closures.

    Attributes
    ----------
    graph : PoseGraph
        One node per key frame.
    counts : ClosureCounts
    seconds : dict of str to float
        Time spent in tracking, the search for closures, and the solver [s].
    """

    def __init__(
        self,
        geometry: LaserGeometry,
        parameters: SlamParameters = FRONT_END,
        closures: ClosureParameters = CLOSURES,
    ) -> None:
        self.graph, self.counts = PoseGraph(), ClosureCounts()
        self.seconds = {"tracking": 0.0, "closures": 0.0, "solver": 0.0}
        self._tracker = ScanTracker(geometry, parameters)
        self._search, self._solver = ClosureSearch(closures), GraphSolver()
        self._submaps = Submaps(closures.submap_travel)
        self._pending: list[Closure] = []

    @property
    def key_frames(self) -> KeyFrames:
        """Key frames, at their current poses."""
        return self._tracker.key_frames

    def add(self, scan: ScanPoints, odometry: Pose2D) -> Tracked:
        """Track a scan; if it is a key frame that finishes a submap, close loops.

        Parameters
        ----------
        scan : ScanPoints
        odometry : Pose2D
            Pose of the robot in the odometry frame.

        Returns
        -------
        Tracked
            The pose is that before loops were closed.
        """
        tracked = self._timed("tracking", lambda: self._tracker.add(scan, odometry))
        if tracked.is_key and self._add_key_frame():
            self._close_loops()
        return tracked

    def finish(self) -> Solution:
        """Close the loops of the last submap, solve the graph and move the key frames; return the solution."""
        if self._submaps.finish() is not None:
            self._close_loops()
        self.counts.lone += len(self._pending)
        self._pending.clear()
        solution = self._solve(FINAL)
        closure = self.graph.edges.kinds == EdgeKind.CLOSURE
        self.counts.distrusted = int((solution.weights[closure] < TRUSTED).sum())
        return solution

    def _add_key_frame(self) -> bool:
        """Append the last key frame to the graph; return whether it finished a submap."""
        frames, graph = self.key_frames, self.graph
        node = graph.add_node(frames.poses[-1])
        step = np.zeros(3)
        if node:
            step = relative(frames.poses[node - 1], frames.poses[node])
            information = edge_information(step, frames.information[node], STEP_FLOOR)
            graph.add_edge(node - 1, node, step, information, EdgeKind.ODOMETRY)
        return self._submaps.add(step) is not None

    def _close_loops(self) -> None:
        """Search for closures of the last finished submap; if any is trusted, solve the graph."""
        submaps = self._submaps.finished
        found = self._timed(
            "closures", lambda: self._search.search(self.key_frames, self.graph, submaps, len(submaps) - 1)
        )
        self.counts.add(found)
        trusted = [closure for closure in found.closures if not closure.wide]
        trusted += self._agreeing([closure for closure in found.closures if closure.wide])
        for closure in trusted:
            self._add_closure(closure)
        if trusted:
            self._solve(CLOSING)

    def _agreeing(self, wide: list[Closure]) -> list[Closure]:
        """Return the closures of wide windows that agree with each other, and keep the rest for later."""
        self._pending += wide
        if not wide:
            return []
        agreeing = self._timed("closures", lambda: agreeing_closures(self.graph, self._pending))
        rest = [closure for closure in self._pending if closure not in agreeing]
        self.counts.lone += max(len(rest) - PENDING, 0)
        self._pending = rest[-PENDING:]
        return agreeing

    def _add_closure(self, closure: Closure) -> None:
        add_closure(self.graph, closure)
        self.counts.closures += 1
        self.counts.edges += len(closure.edges.first)

    def _solve(self, options: SolverOptions) -> Solution:
        solution = self._timed("solver", lambda: self._solver.solve(self.graph, options))
        self.move(solution.poses)
        return solution

    def move(self, poses: NDArray[np.float64]) -> None:
        """Move the key frames and the nodes of the graph to poses (k, 3)."""
        self.graph.move_nodes(poses)
        self._tracker.correct(poses)

    def _timed(self, part: str, work: Callable[[], Result]) -> Result:
        begin = monotonic()
        result = work()
        self.seconds[part] += monotonic() - begin
        return result
