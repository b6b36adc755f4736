"""Requests for plans over the floors of a building, their results, and the lengths that are kept for the next ones."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from engine.specs.containers import MapVersion
from ppaas.bounded import BoundedDict
from ppaas.buildings.layout import BuildingLayout, Place
from ppaas.buildings.planning.legs import Leg
from ppaas.buildings.planning.times import Matrix, Traveller
from ppaas.clock import Clock, monotonic
from ppaas.geometry import Poses
from ppaas.plans.path_service import DEFAULT_TIMEOUT, PathAnswer, PathRequest

KEPT, KEPT_SECONDS = 500, 300.0
"""Largest number of matrices of lengths that are kept, and for how long [s]: zones with times change them."""


@dataclass(frozen=True, slots=True)
class BuildingSpot:
    """Pose on a floor of a building: x, y [m], yaw [rad] in the frame of its map."""

    floor: str
    x: float
    y: float
    yaw: float = 0.0

    @property
    def place(self) -> Place:
        """Pose without the floor."""
        return self.x, self.y, self.yaw


@dataclass(frozen=True, slots=True)
class BuildingScene:
    """Building as a request finds it.

    Parameters
    ----------
    layout : BuildingLayout
    maps : mapping of str to MapVersion
        Map version of each floor, by its name; floors without one are not planned on.
    traveller : Traveller
    closed : frozenset of (floor, door)
        Closed doors.
    parameters : mapping
        Parameters of the global costmap and the planner, as in a ``PathRequest``.
    labels : mapping of str to str
        Labels that the machines of the containers must have.
    timeout : float
        Time limit of each request to a container [s].
    reuse : bool
        Whether stored paths may be returned.
    waits : mapping of (lift, floor) to float
        Waits for lifts that are expected now [s]: infinite for those out of order; others are the mean ones.
    """

    layout: BuildingLayout
    maps: Mapping[str, MapVersion]
    traveller: Traveller = field(default_factory=Traveller)
    closed: frozenset[tuple[str, str]] = frozenset()
    parameters: Mapping[str, Any] = field(default_factory=dict)
    labels: Mapping[str, str] = field(default_factory=dict)
    timeout: float = DEFAULT_TIMEOUT
    reuse: bool = True
    waits: Mapping[tuple[str, str], float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class FloorPath:
    """Path of a drive, as a planning container answered it: its request, the answer and the poses."""

    request: PathRequest
    answer: PathAnswer
    poses: Poses


@dataclass(frozen=True, slots=True)
class BuildingRoute:
    """Route over the floors of a building.

    Parameters
    ----------
    seconds : float
    names : tuple of str
        Ids of the lifts and ways in the order in which they are taken.
    legs : list of Leg
    paths : list of FloorPath or None
        Path of each leg that is a drive; empty if paths were not asked for.
    """

    seconds: float
    names: tuple[str, ...]
    legs: list[Leg]
    paths: list[FloorPath | None]


class KeptLengths:
    """Lengths between the junctions of floors, of the last requests.

    Parameters
    ----------
    clock : callable
        Returns monotonic time [s].
    """

    def __init__(self, clock: Clock = monotonic) -> None:
        self._clock = clock
        self._kept: BoundedDict[tuple[str, ...], tuple[float, Matrix]] = BoundedDict(KEPT)

    def get(self, key: tuple[str, ...]) -> Matrix | None:
        """Return the lengths of a floor [m]; None if they are not known, or too old."""
        kept = self._kept.get(key)
        if kept is None or self._clock() - kept[0] > KEPT_SECONDS:
            return None
        self._kept.move_to_end(key)
        return kept[1]

    def put(self, key: tuple[str, ...], lengths: Matrix) -> None:
        """Keep the lengths of a floor."""
        self._kept[key] = self._clock(), lengths
