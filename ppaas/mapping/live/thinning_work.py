"""Thinning work: outdated beams and redundant key frames leave a mapping, on copies, in another thread."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from ppaas.mapping.graph.pose_graph import PoseGraph
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.lifelong.parameters import LifelongParameters
from ppaas.mapping.lifelong.thinning import Chosen, Thinned, thin
from ppaas.mapping.live.map_canvas import MapCanvas, drawn
from ppaas.mapping.map_drawing import DrawingSettings
from ppaas.maps.cell_rectangle import Rectangle


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
