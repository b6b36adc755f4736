"""Live mapper: tracks scans at once, while loops are closed by work that another thread may run."""

import numpy as np

from ppaas.geometry import Pose2D
from ppaas.mapping.closures.agreement import WAITING, add_closure
from ppaas.mapping.closures.closing import ClosureSearch
from ppaas.mapping.closures.closure import Closure
from ppaas.mapping.closures.parameters import ClosureParameters
from ppaas.mapping.closures.submaps import Submaps
from ppaas.mapping.graph.pose_graph import EdgeKind, Edges, PoseGraph
from ppaas.mapping.graph.solver import GraphSolver
from ppaas.mapping.key_frame_graph import append_key_frame, append_lost, append_placed
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.laser_geometry import LaserGeometry
from ppaas.mapping.lifelong.parameters import LifelongParameters
from ppaas.mapping.lifelong.thinning import Chosen, Thinned, is_due, renumbered_closures
from ppaas.mapping.live.background_work import Closed, ClosingWork, JoinedMap, JoiningWork, ThinnedMap, ThinningWork
from ppaas.mapping.live.map_canvas import MapCanvas
from ppaas.mapping.live.refining_work import RefiningWork
from ppaas.mapping.map_drawing import DEFAULTS, DrawingSettings
from ppaas.mapping.parameters import SlamParameters
from ppaas.mapping.parts.joining import JoiningSchedule
from ppaas.mapping.parts.map_parts import WHOLE, MapParts
from ppaas.mapping.scan_points import ScanPoints
from ppaas.mapping.scan_tracker import ScanTracker, Tracked
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.mapping.serialization.mapping_log import GrowingMapping, Rewritten
from ppaas.mapping.serialization.submap_division import divided_submaps
from ppaas.planar_poses import PoseArray

FRONT_END, CLOSURES = SlamParameters(), ClosureParameters()
"""Default parameters."""


class LiveMapper:
    """Maps scan by scan. Its memory is bounded by the number of key frames and the extent of the map.

    `add` tracks a scan. `next_work` returns the search for closures that is due; run it in any thread, and pass its
    result to `apply`. Key frames made meanwhile are moved along with the last key frame that the work knew. The first
    key frame stays where it is.

    Parameters
    ----------
    geometry : LaserGeometry
    parameters : SlamParameters
        Of the front end.
    closures : ClosureParameters, optional
        Of the search for loop closures; None to close no loops.
    drawing : DrawingSettings
        Of the map.
    lifelong : LifelongParameters, optional
        Of the thinning of the pose graph; None to keep every key frame.

    Attributes
    ----------
    graph : PoseGraph
        One node per key frame.
    thinnings : int
        Number of times that key frames or beams were removed.
    closed : int
        Number of closures in the graph.
    solves : int
        Number of solves that moved key frames.
    parts : MapParts
        Parts of the map that no edge connects, since the robot was carried away. The map shows the current one.
    """

    def __init__(
        self,
        geometry: LaserGeometry,
        parameters: SlamParameters = FRONT_END,
        closures: ClosureParameters | None = CLOSURES,
        drawing: DrawingSettings = DEFAULTS,
        lifelong: LifelongParameters | None = None,
    ) -> None:
        self.graph, self.closed, self.solves, self.thinnings = PoseGraph(), 0, 0, 0
        self.parts, self._joining = WHOLE, JoiningSchedule()
        self._tracker = ScanTracker(geometry, parameters)
        self._search, self._solver = ClosureSearch(closures), GraphSolver()
        self._closes, self._keeps = closures is not None, True
        self._fixed: KeyFrames | None = None
        self._travel = (closures or CLOSURES).submap_travel
        self._submaps, self._searched = Submaps(self._travel), 0
        self._lifelong, self._thinned_to = lifelong, 0
        self._rewritten: Rewritten | None = None
        self._running: ClosingWork | JoiningWork | ThinningWork | RefiningWork | None = None
        self._waiting: list[Closure] = []
        self._drawing, self._canvas, self._drawn = drawing, MapCanvas(drawing), 0

    @property
    def key_frames(self) -> KeyFrames:
        """Key frames, at their current poses."""
        return self._tracker.key_frames

    def add(self, scan: ScanPoints, odometry: Pose2D) -> Tracked:
        """Track a scan, and append it to the graph if it is a key frame.

        Parameters
        ----------
        scan : ScanPoints
        odometry : Pose2D
            Pose of the robot in the odometry frame.

        Raises
        ------
        QuotaExceeded
            The scan is a key frame, and there are as many as allowed.
        """
        # Asked before the scan is added: then the nearest key frame is the scan itself.
        nearest = self._tracker.nearest if self._tracker.is_placing else None
        tracked = self._tracker.add(scan, odometry)
        if not self._keeps or not tracked.is_key:
            return tracked
        if tracked.is_lost:
            self._begin_part()
        elif nearest is not None:
            # The robot was moved by hand, so the odometry since the last key frame is no edge.
            append_placed(self.graph, self.key_frames, nearest)
            self._submaps.finish()
            self._submaps.add(np.zeros(3))
        else:
            self._submaps.add(append_key_frame(self.graph, self.key_frames))
        return tracked

    def _begin_part(self) -> None:
        """Begin a part of the map with the last key frame; the map shows that part only."""
        self._submaps.finish()
        self._submaps.add(append_lost(self.graph, self.key_frames))
        self.parts = self.parts.begin(len(self.key_frames) - 1)
        self._canvas, self._drawn = MapCanvas(self._drawing), 0

    def rebase(self, odometry: Pose2D) -> None:
        """Continue from other odometry, as after a reset of the wheels."""
        self._tracker.rebase(odometry)

    def remount(self, mount: Pose2D) -> None:
        """Take another pose of the laser in the robot's frame; the map stays."""
        self._tracker.remount(mount)

    # -- mappings that are kept ----------------------------------------------------------------------------------------

    @property
    def pose(self) -> Pose2D:
        """Pose of the laser at the last scan, in the map frame."""
        return self._tracker.pose

    @property
    def odometry(self) -> Pose2D:
        """Odometry of the robot at the last scan."""
        return self._tracker.odometry

    @property
    def keeps(self) -> bool:
        """Whether the map grows; otherwise the robot is only localized in it."""
        return self._keeps

    @property
    def searched(self) -> int:
        """Number of submaps whose closures were searched for."""
        # A mapper that resumes this map has to run again the search whose result is not applied yet.
        return self._searched - isinstance(self._running, ClosingWork)

    @property
    def waiting(self) -> list[Closure]:
        """Closures that wait for others to agree with."""
        return list(self._waiting)

    @property
    def is_rewritten(self) -> bool:
        """Whether parts of the map were removed since the last `growing`: its log has to begin again."""
        return self._rewritten is not None

    def growing(self) -> GrowingMapping:
        """Return what a log writer reads. If the map is rewritten, another log has to begin with it."""
        rewritten, self._rewritten = self._rewritten, None
        return GrowingMapping(self.key_frames, self.graph, self.solves, self.waiting, rewritten)

    def mapping(self, laser_frame: str) -> Mapping:
        """Return the mapping as it is now, for another thread; without key frames that are not kept."""
        return Mapping((self._fixed or self.key_frames).snapshot(), self.graph.copy(), laser_frame, self.waiting)

    def load(self, mapping: Mapping, start: Pose2D, *, keeps: bool = True) -> None:
        """Continue a mapping, or localize in it.

        Parameters
        ----------
        mapping : Mapping
            Of the same laser; taken over.
        start : Pose2D
            Pose of the robot near which the next scan is, in the map frame.
        keeps : bool
            Whether the map grows; otherwise the robot is localized in it.

        Raises
        ------
        QuotaExceeded
            There are more key frames than allowed.
        """
        self._tracker.load(mapping.frames, start, keeps=keeps)
        self._fixed = None if keeps else mapping.frames.snapshot()
        self._closes, self._keeps = self._closes and keeps, keeps
        self._take_over(mapping)

    def resume(self, mapping: Mapping, pose: Pose2D, odometry: Pose2D, searched: int) -> None:
        """Continue the mapping of another mapper after its last scan.

        Parameters
        ----------
        mapping : Mapping
            Of the same laser; taken over.
        pose, odometry : Pose2D
        searched : int
            The other mapper's.
        """
        self._tracker.resume(mapping.frames, pose, odometry)
        self._take_over(mapping)
        self._searched = min(searched, len(self._submaps.finished))

    def place(self, robot: Pose2D) -> None:
        """Search the next scan around a pose of the robot in the map frame; there must be a key frame."""
        self._tracker.place(robot)

    def _take_over(self, mapping: Mapping) -> None:
        self.graph, self._waiting = mapping.graph, list(mapping.waiting)
        self._find_parts()
        others = self._divide()
        self.closed, self._searched = int((others.kinds == EdgeKind.CLOSURE).sum()), len(self._submaps.finished)
        self._thinned_to, self._rewritten = len(self.key_frames), None

    def _find_parts(self) -> None:
        self.parts = MapParts.of(self.graph)
        if not self.parts.is_whole:
            self._tracker.restrict(self.parts.last_start)

    def _divide(self) -> Edges:
        """Divide the key frames into submaps, and return the edges that are not steps between successive ones."""
        self._submaps, others = divided_submaps(self.graph, self._travel)
        return others

    # -- work beside the scans -----------------------------------------------------------------------------------------

    def next_work(self) -> ClosingWork | JoiningWork | ThinningWork | None:
        """Return the next work that is due; None if work is running.

        That is the search for closures of a submap, or else for places that the current part of the map and another one
        have in common, or else a thinning.
        """
        if self._running is None:
            self._running = self._next_closing() or self._next_joining() or self._next_thinning()
            return self._running
        return None

    def apply(self, result: Closed | JoinedMap | ThinnedMap | None) -> Pose2D | None:
        """Apply the result of the work that `next_work` returned; None if it failed or was cancelled.

        Returns
        -------
        Pose2D or None
            Motion of the robot's pose in the map frame; None if no key frame has moved.
        """
        self._running = None
        if isinstance(result, ThinnedMap):
            if result.thinned.changes:
                self._thin(*result)
            return None
        if isinstance(result, JoinedMap):
            return self._join(result)
        return None if result is None else self._close(result)

    def _next_closing(self) -> ClosingWork | None:
        if not self._closes or self._searched == len(self._submaps.finished):
            return None
        self._searched += 1
        submaps = self.parts.beside(self._submaps.finished[: self._searched])
        return ClosingWork(
            self.key_frames.snapshot(), self.graph.copy(), submaps, list(self._waiting), self._search, self._solver,
            self._drawing, self._canvas.extent, self.parts,
        )  # fmt: skip

    def _close(self, closed: Closed) -> Pose2D | None:
        self._waiting = closed.waiting[-WAITING:]
        if closed.poses is None:
            return None
        for closure in closed.trusted:
            add_closure(self.graph, closure)
        self.closed += len(closed.trusted)
        return self._move(closed.poses, closed.canvas, closed.part)

    def _next_joining(self) -> JoiningWork | None:
        if not self._closes or not self._joining.is_due(self.parts, self.key_frames.poses):
            return None
        return JoiningWork(Mapping(self.key_frames.snapshot(), self.graph.copy()), self.parts, self._drawing)

    def _join(self, result: JoinedMap) -> Pose2D:
        (one, other), edges, poses = result.joined
        self.graph.add_edges(edges)
        self.parts, self.closed = self.parts.join(one, other), self.closed + 1
        if self.parts.is_whole:
            self._tracker.restrict(0)
        return self._move(poses, result.canvas, min(one, other))

    def _move(self, poses: PoseArray, canvas: MapCanvas | None, part: int) -> Pose2D:
        """Move the first key frames to poses (k, 3); return the motion of the robot. The canvas belongs to a part."""
        before = Pose2D(*self.key_frames.poses[-1].tolist())
        self._tracker.correct(poses)
        self.graph.move_nodes(self.key_frames.poses)
        self.solves += 1
        # Another part may have begun while the work ran, and the map shows that one.
        if canvas is not None and part == self.parts.current:
            self._canvas, self._drawn = canvas, len(poses)
        return Pose2D(*self.key_frames.poses[-1].tolist()) @ before.inverse()

    def _next_thinning(self) -> ThinningWork | None:
        count, settings = len(self.key_frames), self._lifelong
        if settings is None or not self._keeps or not is_due(count, self._thinned_to, settings):
            return None
        if not self.parts.is_whole:
            return None
        # Key frames whose closures are not searched for yet, or still wait, may get edges.
        protected = np.zeros(count, np.bool_)
        protected[self._searched_to if self._closes else count :] = True
        for closure in self._waiting:
            protected[closure.edges.first] = protected[closure.edges.second] = True
        since, self._thinned_to = self._thinned_to, count
        return ThinningWork(
            self.key_frames.snapshot(), self.graph.copy(), Chosen(since, protected), settings, self._drawing,
            self._canvas.extent,
        )  # fmt: skip

    @property
    def _searched_to(self) -> int:
        """Index of the first key frame whose closures were not searched for."""
        return self._submaps.finished[self._searched - 1].end if self._searched else 0

    def _thin(self, thinned: Thinned, canvas: MapCanvas | None) -> None:
        """Take over what thinning left, with the key frames that came meanwhile."""
        graph = thinned.with_later_nodes(self.graph)
        if graph is None:
            # A closure that was found meanwhile begins at a key frame that left: thin everything again.
            self._thinned_to = 0
            return
        kept = thinned.kept
        searched_to, drawn = (int(kept[:end].sum()) for end in (self._searched_to, self._drawn))
        self._drawn = drawn + max(0, self._drawn - len(kept))
        self._tracker.replace(thinned.with_later_frames(self.key_frames), kept)
        self.graph, self._waiting = graph, renumbered_closures(self._waiting, kept)
        others = self._divide()
        self.closed = int((others.kinds == EdgeKind.CLOSURE).sum())
        self._searched = sum(submap.end <= searched_to for submap in self._submaps.finished)
        self._thinned_to = int(kept.sum())
        self._find_parts()
        self.thinnings += 1
        self._rewritten = thinned.rewritten(self.solves)
        if canvas is not None and self.parts.is_whole:
            self._canvas, self._drawn = canvas, self._thinned_to

    # -- map -----------------------------------------------------------------------------------------------------------

    def draw(self) -> MapCanvas:
        """Draw the key frames that are not in the map yet, and return the map.

        Raises
        ------
        QuotaExceeded
            The map would be too large; it is left without them.
        """
        frames = self._fixed or self.key_frames
        first, self._drawn = self._drawn, len(frames)
        for run in self.parts.runs(self.parts.current, len(frames)):
            self._canvas.draw(frames, max(run.start, first), run.stop)
        return self._canvas
