"""Live mapper: tracks scans at once, while loops are closed by work that another thread may run."""

from ppaas.geometry import Pose2D
from ppaas.mapping.closures.agreement import WAITING, add_closure
from ppaas.mapping.closures.closing import ClosureSearch
from ppaas.mapping.closures.closure import Closure
from ppaas.mapping.closures.parameters import ClosureParameters
from ppaas.mapping.closures.submaps import Submaps
from ppaas.mapping.graph.pose_graph import PoseGraph
from ppaas.mapping.graph.solver import GraphSolver
from ppaas.mapping.key_frame_graph import append_key_frame
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.laser_geometry import LaserGeometry
from ppaas.mapping.live.closing_work import Closed, ClosingWork
from ppaas.mapping.live.map_canvas import MapCanvas
from ppaas.mapping.map_drawing import DEFAULTS, DrawingSettings
from ppaas.mapping.parameters import SlamParameters
from ppaas.mapping.scan_points import ScanPoints
from ppaas.mapping.scan_tracker import ScanTracker, Tracked

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

    Attributes
    ----------
    graph : PoseGraph
        One node per key frame.
    closed : int
        Number of closures in the graph.
    """

    def __init__(
        self,
        geometry: LaserGeometry,
        parameters: SlamParameters = FRONT_END,
        closures: ClosureParameters | None = CLOSURES,
        drawing: DrawingSettings = DEFAULTS,
    ) -> None:
        self.graph, self.closed = PoseGraph(), 0
        self._tracker = ScanTracker(geometry, parameters)
        self._search, self._solver = ClosureSearch(closures), GraphSolver()
        self._closes = closures is not None
        self._submaps = Submaps((closures or CLOSURES).submap_travel)
        self._searched = 0
        self._running: ClosingWork | None = None
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
        tracked = self._tracker.add(scan, odometry)
        if tracked.is_key:
            self._submaps.add(append_key_frame(self.graph, self.key_frames))
        return tracked

    def rebase(self, odometry: Pose2D) -> None:
        """Continue from other odometry, as after a reset of the wheels."""
        self._tracker.rebase(odometry)

    # -- closures ------------------------------------------------------------------------------------------------------

    def next_work(self) -> ClosingWork | None:
        """Return the next search for closures; None if one is running, or no submap is waiting."""
        if not self._closes or self._running is not None or self._searched == len(self._submaps.finished):
            return None
        self._searched += 1
        self._running = ClosingWork(
            self.key_frames.snapshot(), self.graph.copy(), self._submaps.finished[: self._searched],
            list(self._waiting), self._search, self._solver, self._drawing, self._canvas.extent,
        )  # fmt: skip
        return self._running

    def apply(self, closed: Closed | None) -> Pose2D | None:
        """Apply the result of the work that `next_work` returned; None if it failed or was cancelled.

        Returns
        -------
        Pose2D or None
            Motion of the robot's pose in the map frame; None if no key frame has moved.
        """
        self._running = None
        if closed is None:
            return None
        self._waiting = closed.waiting[-WAITING:]
        if closed.poses is None:
            return None
        for closure in closed.trusted:
            add_closure(self.graph, closure)
        self.closed += len(closed.trusted)
        before = Pose2D(*self.key_frames.poses[-1].tolist())
        self._tracker.correct(closed.poses)
        self.graph.move_nodes(self.key_frames.poses)
        if closed.canvas is not None:
            self._canvas, self._drawn = closed.canvas, len(closed.poses)
        return Pose2D(*self.key_frames.poses[-1].tolist()) @ before.inverse()

    # -- map -----------------------------------------------------------------------------------------------------------

    def draw(self) -> MapCanvas:
        """Draw the key frames that are not in the map yet, and return the map.

        Raises
        ------
        QuotaExceeded
            The map would be too large; it is left without them.
        """
        first, self._drawn = self._drawn, len(self.key_frames)
        self._canvas.draw(self.key_frames, first)
        return self._canvas
