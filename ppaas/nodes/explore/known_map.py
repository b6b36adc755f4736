"""Map of the node ``explore``, from the topics ``map`` and ``map_updates``, and its surveys."""

from collections.abc import Callable

from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.maps.occupancy import GridMapMessage, MapChange
from ppaas.messages.base.map_msgs import OccupancyGridUpdate
from ppaas.messages.nav_msgs import OccupancyGrid
from ppaas.nodes.base import Context, Job, Payload
from ppaas.nodes.explore.survey import Build, Survey, survey_work
from ppaas.nodes.move_base.static_layer import MapMessage, applied

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
        elif isinstance(message, MapChange | OccupancyGridUpdate):
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
