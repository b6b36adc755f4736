"""Joining work: the search for places of other parts of the map, on copies, in another thread."""

from collections.abc import Callable
from dataclasses import dataclass

from ppaas.mapping.live.map_canvas import MapCanvas, drawn
from ppaas.mapping.map_drawing import DrawingSettings
from ppaas.mapping.parts.joining import Joined, join
from ppaas.mapping.parts.map_parts import MapParts
from ppaas.mapping.serialization.mapping import Mapping


@dataclass(frozen=True, slots=True)
class JoinedMap:
    """Result of a search.

    Parameters
    ----------
    joined : Joined
    canvas : MapCanvas, optional
        Map of the part that the two have become; None if it would be too large.
    """

    joined: Joined
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
