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
from ppaas.mapping.key_frame_graph import append_key_frame, append_placed
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.laser_geometry import LaserGeometry
from ppaas.mapping.lifelong.parameters import LifelongParameters
from ppaas.mapping.lifelong.thinning import Chosen, Thinned, is_due, renumbered_closures
from ppaas.mapping.live.closing_work import Closed, ClosingWork
from ppaas.mapping.live.map_canvas import MapCanvas
from ppaas.mapping.live.thinning_work import ThinnedMap, ThinningWork
from ppaas.mapping.map_drawing import DEFAULTS, DrawingSettings
from ppaas.mapping.parameters import SlamParameters
from ppaas.mapping.scan_points import ScanPoints
from ppaas.mapping.scan_tracker import ScanTracker, Tracked
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.mapping.serialization.mapping_log import GrowingMapping, Rewritten
from ppaas.mapping.serialization.submap_division import divided_submaps

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
        self._tracker = ScanTracker(geometry, parameters)
        self._search, self._solver = ClosureSearch(closures), GraphSolver()
        self._closes, self._keeps = closures is not None, True
        self._fixed: KeyFrames | None = None
        self._travel = (closures or CLOSURES).submap_travel
        self._submaps, self._searched = Submaps(self._travel), 0
        self._lifelong, self._thinned_to = lifelong, 0
        self._rewritten: Rewritten | None = None
        self._running: ClosingWork | ThinningWork | None = None
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
        nearest = self._tracker.nearest if self._tracker.is_placing else None
        tracked = self._tracker.add(scan, odometry)
        if not self._keeps or not tracked.is_key:
            return tracked
        if nearest is not None:
            append_placed(self.graph, self.key_frames, nearest)
            self._submaps.finish()
            self._submaps.add(np.zeros(3))
        else:
            self._submaps.add(append_key_frame(self.graph, self.key_frames))
        return tracked

    def rebase(self, odometry: Pose2D) -> None:
        """Continue from other odometry, as after a reset of the wheels."""
        self._tracker.rebase(odometry)

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
            Those of the other mapper.
        """
        self._tracker.resume(mapping.frames, pose, odometry)
        self._take_over(mapping)
        self._searched = min(searched, len(self._submaps.finished))

    def place(self, robot: Pose2D) -> None:
        """Search the next scan around a pose of the robot in the map frame; there must be a key frame."""
        self._tracker.place(robot)

    def _take_over(self, mapping: Mapping) -> None:
        self.graph, self._waiting = mapping.graph, list(mapping.waiting)
        others = self._divide()
        self.closed, self._searched = int((others.kinds == EdgeKind.CLOSURE).sum()), len(self._submaps.finished)
        self._thinned_to, self._rewritten = len(self.key_frames), None

    def _divide(self) -> Edges:
        """Divide the key frames into submaps, and return the edges that are not steps between successive ones."""
        self._submaps, others = divided_submaps(self.graph, self._travel)
        return others

    # -- work beside the scans -----------------------------------------------------------------------------------------

    def next_work(self) -> ClosingWork | ThinningWork | None:
        """Return the next search for closures, or else a thinning; None if work is running, or none is due."""
        if self._running is None:
            self._running = self._next_closing() or self._next_thinning()
            return self._running
        return None

    def apply(self, result: Closed | ThinnedMap | None) -> Pose2D | None:
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
        return None if result is None else self._close(result)

    def _next_closing(self) -> ClosingWork | None:
        if not self._closes or self._searched == len(self._submaps.finished):
            return None
        self._searched += 1
        return ClosingWork(
            self.key_frames.snapshot(), self.graph.copy(), self._submaps.finished[: self._searched],
            list(self._waiting), self._search, self._solver, self._drawing, self._canvas.extent,
        )  # fmt: skip

    def _close(self, closed: Closed) -> Pose2D | None:
        self._waiting = closed.waiting[-WAITING:]
        if closed.poses is None:
            return None
        for closure in closed.trusted:
            add_closure(self.graph, closure)
        self.closed += len(closed.trusted)
        self.solves += 1
        before = Pose2D(*self.key_frames.poses[-1].tolist())
        self._tracker.correct(closed.poses)
        self.graph.move_nodes(self.key_frames.poses)
        if closed.canvas is not None:
            self._canvas, self._drawn = closed.canvas, len(closed.poses)
        return Pose2D(*self.key_frames.poses[-1].tolist()) @ before.inverse()

    def _next_thinning(self) -> ThinningWork | None:
        count, settings = len(self.key_frames), self._lifelong
        if settings is None or not self._keeps or not is_due(count, self._thinned_to, settings):
            return None
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
            self._thinned_to = 0
            return
        kept = thinned.kept
        searched_to, self._drawn = (int(kept[:end].sum()) for end in (self._searched_to, self._drawn))
        self._tracker.replace(thinned.with_later_frames(self.key_frames), kept)
        self.graph, self._waiting = graph, renumbered_closures(self._waiting, kept)
        others = self._divide()
        self.closed = int((others.kinds == EdgeKind.CLOSURE).sum())
        self._searched = sum(submap.end <= searched_to for submap in self._submaps.finished)
        self._thinned_to = int(kept.sum())
        self.thinnings += 1
        self._rewritten = thinned.rewritten(self.solves)
        if canvas is not None:
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
        self._canvas.draw(frames, first)
        return self._canvas
