"""Survey of a map: the frontiers that a robot can approach, computed in a job."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import PlanCancelled
from ppaas.exploration.approaches import Approach, Reach
from ppaas.exploration.frontiers import find_frontiers, known_area
from ppaas.exploration.given_up import GivenUp
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.nodes.jobs import LongWork
from ppaas.nodes.move_base.static_layer import MapMessage, applied

Build = Callable[[GridMap], MapLayers]

Points = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Survey:
    """Map with the frontiers of it that a robot can approach.

    Parameters
    ----------
    grid : GridMap or None
        The map; None if no message had a valid one.
    approaches : tuple of Approach
        Those that were given up are left out.
    points : tuple of (n, 2) array
        Cells of the frontier of each approach, x, y [m].
    area : float
        Known area [m²].
    """

    grid: GridMap | None
    approaches: tuple[Approach, ...] = ()
    points: tuple[Points, ...] = ()
    area: float = 0.0

    def points_of(self, approach: Approach) -> Points:
        """Return the cells of the frontier of one of the approaches, x, y [m]."""
        return next(found for each, found in zip(self.approaches, self.points, strict=True) if each is approach)

    def without(self, given_up: GivenUp) -> "Survey":
        """Return the survey without the frontiers that have been given up."""
        pairs = zip(self.approaches, self.points, strict=True)
        kept = [(approach, found) for approach, found in pairs if not given_up.covers(found)]
        return replace(self, approaches=tuple(each for each, _ in kept), points=tuple(found for _, found in kept))


def survey_work(
    grid: GridMap | None, messages: Sequence[MapMessage], robot: Pose2D, smallest: float, build: Build
) -> LongWork[Survey]:
    """Return the work of a job that surveys a map.

    It raises ``StartOutsideMap`` or ``StartOccupied`` if the robot is not on free space of the map.

    Parameters
    ----------
    grid : GridMap, optional
        The map before the messages.
    messages : sequence of messages
        New maps and changes.
    robot : Pose2D
        In the map frame.
    smallest : float
        Smaller frontiers are ignored [m].
    build : callable
        Returns the layers of a grid for the robot.
    """

    def work(cancelled: Callable[[], bool]) -> Survey:
        def check() -> None:
            if cancelled():
                raise PlanCancelled("exploring has ended")

        latest = applied(grid, messages)
        if latest is None:
            return Survey(None)
        frontiers = find_frontiers(latest, smallest)
        reach = Reach(latest, build(latest).costmap, robot, check)
        approaches = tuple(reach.approaches(frontiers))
        points = tuple(latest.info.to_world(each.frontier.cells) for each in approaches)
        return Survey(latest, approaches, points, known_area(latest))

    return LongWork(work)
