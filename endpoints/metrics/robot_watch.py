"""State of the robots of a cloud, as their containers report it: connection, stops, waits and batteries."""

from collections.abc import Callable
from dataclasses import dataclass

from engine.control.master_calls.control_plane import ContainerCalls
from engine.links.place_link import PlaceLink
from engine.master.places import robot_key
from engine.specs.robot_report import StateReport
from ppaas.clock import Clock, monotonic
from ppaas.messages.actionlib_msgs import Status

WAITS = "waiting: "
"""Beginning of the reason why Move Base lets a robot with a goal stand."""


@dataclass(frozen=True, slots=True)
class RobotSeen:
    """A robot that has a container.

    Parameters
    ----------
    user, robot : str
    connected, stopped : bool
        Whether its own socket is open, and whether a stop holds it.
    report : StateReport
        What its container reported last.
    """

    user: str
    robot: str
    connected: bool
    stopped: bool
    report: StateReport

    @property
    def waits(self) -> bool:
        """Return whether it stands with a goal, for a reason other than a stop: traffic, people, or a lost pose."""
        active = self.connected and self.report.goal == Status.ACTIVE
        return active and not self.stopped and self.report.goal_text.startswith(WAITS)


class RobotWatch:
    """Reads the state of the robots, and notes since when each of them waits.

    Parameters
    ----------
    containers : ContainerCalls
        Lists the containers.
    place : callable
        Returns the place of a name, if it is open.
    clock : callable
        Returns monotonic time [s].
    """

    def __init__(
        self, containers: ContainerCalls, place: Callable[[str], PlaceLink | None], clock: Clock = monotonic
    ) -> None:
        self._containers = containers
        self._place = place
        self._clock = clock
        self._since: dict[tuple[str, str], float] = {}

    async def read(self) -> tuple[list[RobotSeen], float]:
        """Return the robots, and for how long the one that has waited longest was found waiting in all readings [s]."""
        listed = await self._containers.views(None)
        robots = [self._seen(one.user, one.robot, one.connected) for one in listed if one.robot is not None]
        now = self._clock()
        waiting = [(one.user, one.robot) for one in robots if one.waits]
        self._since = {name: self._since.get(name, now) for name in waiting}
        return robots, max((now - since for since in self._since.values()), default=0.0)

    def _seen(self, user: str, robot: str, connected: bool) -> RobotSeen:
        place = self._place(robot_key(user, robot))
        if place is None:
            return RobotSeen(user, robot, connected, stopped=False, report=StateReport())
        stops = () if place.stops is None else place.stops.stops
        return RobotSeen(user, robot, connected, stopped=bool(stops), report=place.beat.report)
