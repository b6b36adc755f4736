"""Map of the node ``explore``, from the topics ``map`` and ``map_updates``, and its surveys, made in jobs."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import PlanCancelled, PPaaSError
from ppaas.exploration.approaches import Approach, Reach
from ppaas.exploration.frontiers import find_frontiers, known_area
from ppaas.exploration.given_up import GivenUp
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.maps.occupancy import GridMapMessage, GridUpdate
from ppaas.messages.base.map_msgs import OccupancyGridUpdate
from ppaas.messages.nav_msgs import OccupancyGrid
from ppaas.nodes.base import Context, Job, Payload
from ppaas.nodes.jobs import LongWork
from ppaas.nodes.move_base.static_layer import MapMessage, applied

# -- survey of a map ---------------------------------------------------------------------------------------------------

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


# -- map of the node ``explore``, from the topics ``map`` and ``map_updates``, and its surveys -------------------------

MOST_MESSAGES = 64
"""Changes that are collected before they are applied."""


class KnownMap:
    """Keeps the map of the topics, and surveys it in jobs.

    Parameters
    ----------
    context : Context
        Of the node.
    build : callable
        Returns the layers of a grid for the robot.
    smallest : float
        Smaller frontiers are ignored [m].
    """

    def __init__(self, context: Context, build: Build, smallest: float) -> None:
        self._context, self._build, self._smallest = context, build, smallest
        self._grid: GridMap | None = None
        self._messages: list[MapMessage] = []
        self._job: Job | None = None
        self._changed = False

    @property
    def surveying(self) -> bool:
        """Whether a survey runs."""
        return self._job is not None

    @property
    def has_map(self) -> bool:
        """Whether a map was received."""
        return self._grid is not None or bool(self._messages)

    @property
    def has_changed(self) -> bool:
        """Whether a survey is due: the map has changed since the last one began, or `expect_change` was called."""
        return self._changed

    def expect_change(self) -> None:
        """Make a survey due although the map has not changed."""
        self._changed = True

    def take(self, message: Payload) -> bool:
        """Take a message of one of the topics; return whether it is of one."""
        if isinstance(message, GridMapMessage | OccupancyGrid):
            self._messages = [message]
        elif isinstance(message, GridUpdate | OccupancyGridUpdate):
            if self.has_map:  # changes refer to a whole map
                self._messages.append(message)
        else:
            return False
        self._changed = True
        if len(self._messages) > MOST_MESSAGES and self._job is None:
            self._grid, self._messages = applied(self._grid, self._messages), []
        return True

    def survey(self, robot: Pose2D, done: Callable[[Survey | PPaaSError], None]) -> None:
        """Survey the map in a job; ``done`` gets the survey, or the error.

        Parameters
        ----------
        robot : Pose2D
            In the map frame.
        done : callable
            Called in the thread of the node.
        """
        messages, self._changed = tuple(self._messages), False
        running = True

        def finished(surveyed: Survey | PPaaSError) -> None:
            nonlocal running
            running, self._job = False, None
            if isinstance(surveyed, Survey):
                taken = set(map(id, messages))
                self._grid = surveyed.grid
                self._messages = [message for message in self._messages if id(message) not in taken]
            else:
                self._changed = True
            done(surveyed)

        job = self._context.start(survey_work(self._grid, messages, robot, self._smallest, self._build), finished)
        if running:
            self._job = job

    def cancel(self) -> None:
        """Cancel the survey that runs, if there is one."""
        if self._job is not None:
            self._job.cancel()
