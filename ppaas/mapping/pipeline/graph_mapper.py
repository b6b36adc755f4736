"""Graph mapper: tracks scans, finds loop closures, and keeps the pose graph of the key frames solved."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import TypeVar

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from ppaas.clock import monotonic
from ppaas.geometry import Pose2D
from ppaas.mapping.closures.agreement import CLOSING, GRADUATED, WAITING, add_closure, divide
from ppaas.mapping.closures.closing import ClosureSearch
from ppaas.mapping.closures.closure import Closure, Links, Searched
from ppaas.mapping.closures.parameters import ClosureParameters
from ppaas.mapping.closures.submaps import Submaps
from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph, measured_odometry
from ppaas.mapping.graph.robust_weights import TRUSTED
from ppaas.mapping.graph.solver import GraphSolver, Solution, SolverOptions
from ppaas.mapping.key_frame_graph import append_key_frame, append_lost
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.laser_geometry import LaserGeometry
from ppaas.mapping.parameters import SlamParameters
from ppaas.mapping.parts.joining import join, placed_beside
from ppaas.mapping.parts.map_parts import WHOLE
from ppaas.mapping.refinement import refine
from ppaas.mapping.scan_points import ScanPoints
from ppaas.mapping.scan_tracker import ScanTracker, Tracked
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.mapping.serialization.submap_division import divided_submaps
from ppaas.planar_poses import PoseArray, relative

FRONT_END, CLOSURES = SlamParameters(), ClosureParameters()
"""Default parameters."""

PASSES = 2
"""Largest number of searches of all submaps after the drive."""

BESIDE = 5.0
"""Distance between parts of the map that were not joined [m]."""

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
    weights : (m,) array
        Weights of the edges of the graph after `finish`, from 0 to 1.
    seconds : dict of str to float
        Time spent in tracking, the search for closures, and the solver [s].
    parts : MapParts
        Parts of the map that no edge connects, since the robot was carried away. After `finish` they lie side by side.
    steps : list of (3,) array
        Pose of each key frame in the frame of the one before by tracking alone; the first one's is 0.
    """

    def __init__(
        self,
        geometry: LaserGeometry,
        parameters: SlamParameters = FRONT_END,
        closures: ClosureParameters = CLOSURES,
    ) -> None:
        self.graph, self.counts = PoseGraph(), ClosureCounts()
        self.weights: NDArray[np.float64] = np.empty(0)
        self.seconds = {"tracking": 0.0, "closures": 0.0, "solver": 0.0}
        self._tracker = ScanTracker(geometry, parameters)
        self._search, self._solver = ClosureSearch(closures), GraphSolver()
        self._submaps = Submaps(closures.submap_travel)
        self._waiting: list[Closure] = []
        self.parts, self.steps = WHOLE, list[PoseArray]()

    @classmethod
    def of(cls, mapping: Mapping, closures: ClosureParameters = CLOSURES) -> "GraphMapper":
        """Return the mapper of a mapping that was made elsewhere, whose loops `finish` closes.

        Parameters
        ----------
        mapping : Mapping
            Taken over; the searches for closures of all but its last submap are taken to be done.
        closures : ClosureParameters
        """
        frames, graph = mapping.frames, mapping.graph
        # A map that was made with a higher limit can be finished too.
        most = max(FRONT_END.max_key_frames, len(frames))
        mapper = cls(frames.geometry, replace(FRONT_END, max_key_frames=most), closures)
        pose = Pose2D(*frames.poses[-1].tolist())
        # The odometry of the robot is not stored; no scan follows that would need it.
        mapper._tracker.resume(frames, pose, pose @ frames.geometry.mount.inverse())
        mapper.graph, mapper._waiting = graph, list(mapping.waiting)
        mapper._submaps, _ = divided_submaps(graph, closures.submap_travel)
        return mapper

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
        if tracked.is_lost:
            self._begin_part()
        elif tracked.is_key:
            self.steps.append(append_key_frame(self.graph, self.key_frames))
            if self._submaps.add(self.steps[-1]) is not None:
                self._close_loops()
        return tracked

    def rebase(self, odometry: Pose2D) -> None:
        """Continue from other odometry, as after a reset of the wheels."""
        self._tracker.rebase(odometry)

    def _begin_part(self) -> None:
        """Begin a part of the map with the last key frame."""
        if self._submaps.finish() is not None:
            self._close_loops()
        self.steps.append(relative(self.key_frames.poses[-2], self.key_frames.poses[-1]))
        self._submaps.add(append_lost(self.graph, self.key_frames))
        self.parts = self.parts.begin(len(self.key_frames) - 1)

    def finish(self, done: Callable[[int, int], None] | None = None) -> Solution:
        """Close the loops of the last submap, solve the graph and move the key frames; return the solution.

        Parameters
        ----------
        done : callable, optional
            Called with the number of submaps searched and the number to search at most, after each.
        """
        if self._submaps.finish() is not None:
            self._close_loops()
        # Parts first: closures are only searched for within a part.
        self._join_parts()
        for number in range(PASSES):
            if not self._close_again(done, number):
                break
        self.counts.lone += len(self._waiting)
        self._waiting.clear()
        solution = self._solve(GRADUATED)
        if not self.parts.is_whole:
            self.move(placed_beside(self._mapping(), self.parts, BESIDE))
        self.weights = solution.weights[: self.graph.edge_count]
        closure = self.graph.edges.kinds == EdgeKind.CLOSURE
        self.counts.distrusted = int((self.weights[closure] < TRUSTED).sum())
        return solution

    def _close_loops(self) -> None:
        """Search for closures of the last finished submap; if any is trusted, solve the graph."""
        submaps = self.parts.beside(self._submaps.finished)
        found = self._timed(
            "closures", lambda: self._search.search(self.key_frames, self.graph, submaps, len(submaps) - 1)
        )
        if self._trust(found):
            self._solve(CLOSING)

    def _trust(self, found: Searched) -> bool:
        """Add the closures of a search that are trusted; return whether there is one."""
        self.counts.add(found)
        trusted, rest = self._timed("closures", lambda: divide(self.graph, found.closures, self._waiting))
        self.counts.lone += max(len(rest) - WAITING, 0)
        self._waiting = rest[-WAITING:]
        for closure in trusted:
            self._add_closure(closure)
        return bool(trusted)

    def _close_again(self, done: Callable[[int, int], None] | None, number: int) -> bool:
        """Search all submaps again at the poses that the closures gave, for those missing; return whether any was."""
        count, searched, of_all = self.counts.closures, 0, PASSES * len(self._submaps.finished)
        for submaps in self.parts.by_run(self._submaps.finished):
            links = Links(submaps, self.graph.edges)
            for of in range(len(submaps)):
                search = partial(self._search.search, self.key_frames, self.graph, submaps, of, links)
                self._trust(self._timed("closures", search))
                searched += 1
                if done is not None:
                    done(number * len(self._submaps.finished) + searched, of_all)
        if self.counts.closures == count:
            return False
        self._solve(GRADUATED)
        return True

    def _join_parts(self) -> None:
        """Join the last part with the others, as far as they are recognized."""
        while not self.parts.is_whole:
            joined = self._timed("closures", lambda: join(self._mapping(), self.parts, lambda: False))
            if joined is None:
                return
            self.graph.add_edges(joined.edges)
            self.parts = self.parts.join(*joined.numbers)
            self.move(joined.poses)
            self.counts.closures += 1
            self.counts.edges += len(joined.edges.first)

    def _mapping(self) -> Mapping:
        return Mapping(self.key_frames, self.graph)

    def _add_closure(self, closure: Closure) -> None:
        add_closure(self.graph, closure)
        self.counts.closures += 1
        self.counts.edges += len(closure.edges.first)

    def _solve(self, options: SolverOptions) -> Solution:
        solution = self._timed("solver", lambda: self._solver.solve(self.parts.held(self.graph), options))
        self.move(solution.poses)
        return solution

    def move(self, poses: PoseArray) -> None:
        """Move the key frames and the nodes of the graph to poses (k, 3)."""
        self.graph.move_nodes(poses)
        self._tracker.correct(poses)

    def _timed(self, part: str, work: Callable[[], Result]) -> Result:
        begin = monotonic()
        result = work()
        self.seconds[part] += monotonic() - begin
        return result


# -- finish of a mapping that a robot made while it drove --------------------------------------------------------------


def finish_mapping(
    mapping: Mapping,
    closures: ClosureParameters | None = CLOSURES,
    done: Callable[[str, float], None] | None = None,
) -> Mapping:
    """Finish a mapping as `map_log` does at the end of a log: search for missing loops, solve, and refine.

    Parameters
    ----------
    mapping : Mapping
        Taken over.
    closures : ClosureParameters or None
        Of the search for loop closures; None to close no loops.
    done : callable, optional
        Called with the name of the part that is done, ``loops`` or ``alignment``, and how much of it is, from 0 to 1.

    Raises
    ------
    InvalidGraph
        The normal equations are not positive definite.
    """
    frames, graph, report = mapping.frames, mapping.graph, done or _ignore
    if closures is None:
        mapping.move(GraphSolver().solve(graph, GRADUATED).poses)
    else:
        report("loops", 0.0)
        GraphMapper.of(mapping, closures).finish(lambda searched, of: report("loops", searched / of))
    report("alignment", 0.0)
    mapping.move(refine(frames, graph.poses, measured_odometry(graph.edges)).poses)
    return Mapping(frames, graph, mapping.laser_frame)


def _ignore(_part: str, _done: float) -> None:
    """Report nothing."""
