"""Watched robot: what the diagnosis knows of a robot beside its messages."""

from collections.abc import Callable
from dataclasses import dataclass, field

from ppaas.costmap.map_layers import MapLayers
from ppaas.nodes.frames import FrameNames


@dataclass(frozen=True, slots=True)
class WatchedRobot:
    """Properties of a robot that its messages do not contain.

    Parameters
    ----------
    id : str
    names : FrameNames
        Names of its frames.
    layers : callable
        Returns the map that it drives on now, None if it makes one.
    makes_map : bool
        Whether it makes a new map.
    camera : bool
        Whether a depth camera makes its scans.
    follows_paths : bool
        Whether it localizes itself and follows paths itself, as an AGV does.
    radius : float
        Largest radius around its centre within its footprint [m].
    """

    id: str = "ROBOT"
    names: FrameNames = field(default_factory=FrameNames)
    layers: Callable[[], MapLayers | None] = lambda: None
    makes_map: bool = False
    camera: bool = False
    follows_paths: bool = False
    radius: float = 0.0
