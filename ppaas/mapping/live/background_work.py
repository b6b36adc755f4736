"""Work of a live mapper that another thread may run on copies: loop closures, places of other parts, and thinning."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from ppaas.mapping.closures.agreement import CLOSING, GRADUATED, add_closure, divide
from ppaas.mapping.closures.closing import ClosureSearch
from ppaas.mapping.closures.closure import Closure, Searched
from ppaas.mapping.closures.submaps import Submap
from ppaas.mapping.graph.pose_graph import PoseGraph
from ppaas.mapping.graph.solver import GraphSolver
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.lifelong.parameters import LifelongParameters
from ppaas.mapping.lifelong.thinning import Chosen, Thinned, thin
from ppaas.mapping.live.map_canvas import MapCanvas, drawn
from ppaas.mapping.map_drawing import DrawingSettings
from ppaas.mapping.parts.joining import JoinedParts, join
from ppaas.mapping.parts.map_parts import WHOLE, MapParts
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.maps.cell_rectangle import Rectangle
from ppaas.planar_poses import PoseArray

# -- loop closures of a submap, and the solve --------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Closed:
    """Result of a search.

    Parameters
    ----------
    searched : Searched
        All closures found, and those refused.
    trusted : list of Closure
        Closures that enter the graph.
    waiting : list of Closure
        Closures of wide windows that wait for others to agree with.
    poses : (k, 3) array, optional
        Poses of the key frames after the solve; None if no closure is trusted.
    canvas : MapCanvas, optional
        Map of these key frames at these poses; None if it would be too large.
    part : int
        Part of the map that it shows.
    """

    searched: Searched
    trusted: list[Closure]
    waiting: list[Closure]
    poses: PoseArray | None = None
    canvas: MapCanvas | None = None
    part: int = 0


@dataclass(frozen=True, slots=True)
class ClosingWork:
    """Search for the closures of one submap. It changes nothing that is given, and may be run again.

    Parameters
    ----------
    frames : KeyFrames
        Snapshot.
    graph : PoseGraph
        Copy of the graph, one node per key frame.
    submaps : list of Submap
        Finished submaps, the last of which is searched for.
    waiting : list of Closure
        Closures of earlier submaps that wait for others.
    search : ClosureSearch
    solver : GraphSolver
        Used by one thread at once.
    drawing : DrawingSettings
    extent : Rectangle or None
        Extent of the map, which is kept.
    parts : MapParts
        Parts of the map, of which the current one is drawn.
    """

    frames: KeyFrames
    graph: PoseGraph
    submaps: list[Submap]
    waiting: list[Closure]
    search: ClosureSearch
    solver: GraphSolver
    drawing: DrawingSettings
    extent: Rectangle | None
    parts: MapParts = WHOLE

    def __call__(self, cancelled: Callable[[], bool]) -> Closed | None:
        """Return the closures and the corrected poses; None if the work was cancelled."""
        searched = self.search.search(self.frames, self.graph, self.submaps, len(self.submaps) - 1)
        trusted, rest = divide(self.graph, searched.closures, self.waiting)
        if cancelled():
            return None
        if not trusted:
            return Closed(searched, [], rest)
        poses = self._solved(trusted)
        canvas = drawn(self.frames.at(poses), self.drawing, self.extent, self.parts)
        return Closed(searched, trusted, rest, poses, canvas, self.parts.current)

    def _solved(self, trusted: list[Closure]) -> PoseArray:
        graph = self.parts.held(self.graph)
        for closure in trusted:
            add_closure(graph, closure)
        # Where a wide window was needed, the robot was far from its place.
        far = any(closure.wide for closure in trusted)
        return self.solver.solve(graph, GRADUATED if far else CLOSING).poses


# -- places of other parts of the map ----------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class JoinedMap:
    """Result of a search.

    Parameters
    ----------
    joined : JoinedParts
    canvas : MapCanvas, optional
        Map of the part that the two have become; None if it would be too large.
    """

    joined: JoinedParts
    canvas: MapCanvas | None


@dataclass(frozen=True, slots=True)
class JoiningWork:
    """Search for places of the other parts in the current one. It changes nothing that is given, and may be run again.

    Parameters
    ----------
    mapping : Mapping
        Snapshot of the key frames, and a copy of their graph.
    parts : MapParts
    drawing : DrawingSettings
    """

    mapping: Mapping
    parts: MapParts
    drawing: DrawingSettings

    def __call__(self, cancelled: Callable[[], bool]) -> JoinedMap | None:
        """Return the joined parts; None if no other part is recognized, or the work was cancelled.

        Raises
        ------
        InvalidGraph
            The joined graph cannot be solved.
        """
        joined = join(self.mapping, self.parts, cancelled)
        if joined is None:
            return None
        frames = self.mapping.frames.at(joined.poses)
        return JoinedMap(joined, drawn(frames, self.drawing, parts=self.parts.join(*joined.numbers)))


# -- outdated beams and redundant key frames ---------------------------------------------------------------------------


class ThinnedMap(NamedTuple):
    """Result of a thinning.

    Parameters
    ----------
    thinned : Thinned
    canvas : MapCanvas, optional
        Map of the key frames that are left; None if nothing has changed, or if it would be too large.
    """

    thinned: Thinned
    canvas: MapCanvas | None


@dataclass(frozen=True, slots=True)
class ThinningWork:
    """Search for outdated beams and redundant key frames. It changes nothing that is given, and may be run again.

    Parameters
    ----------
    frames : KeyFrames
        Snapshot.
    graph : PoseGraph
        Copy of the graph, one node per key frame.
    chosen : Chosen
        Key frames that are judged.
    parameters : LifelongParameters
    drawing : DrawingSettings
    extent : Rectangle or None
        Extent of the map, which is kept.
    """

    frames: KeyFrames
    graph: PoseGraph
    chosen: Chosen
    parameters: LifelongParameters
    drawing: DrawingSettings
    extent: Rectangle | None

    def __call__(self, cancelled: Callable[[], bool]) -> ThinnedMap | None:
        """Return what is left; None if the work was cancelled."""
        thinned = thin(self.frames, self.graph, self.chosen, self.parameters, cancelled)
        if thinned is None:
            return None
        return ThinnedMap(thinned, drawn(thinned.frames, self.drawing, self.extent) if thinned.changes else None)
