"""Log of the rides in a simulated building: who rode when, from where to where, and how long it waited."""

import math
from dataclasses import dataclass

from ppaas.buildings.layout import Landing
from ppaas.buildings.riding.car_frame import is_inside
from ppaas.geometry import Pose2D
from robots.sim.floors.building import SimulatedBuilding
from robots.sim.robot import SimulatedRobot

PERIOD = 0.2
"""Time between two looks at the robots [s]."""

NEAR = 1.0
"""Distance from a lift's door, or the place before it, within which a robot waits for the lift [m]."""


@dataclass(frozen=True, slots=True)
class LoggedRide:
    """A ride of a robot in a lift.

    Parameters
    ----------
    robot : int
        Index of the robot in the building.
    lift, origin, destination : str
        The lift, and the floors where the robot entered and left the car, which may be the same.
    waited : float
        Time from its arrival before the lift until it was in the car [s].
    rode : float
        Time in the car [s].
    left : float
        Simulated time at which it was out [s].
    """

    robot: int
    lift: str
    origin: str
    destination: str
    waited: float
    rode: float
    left: float


@dataclass(slots=True)
class _Watched:
    """A robot: since when it waits near lifts, and what it rides in."""

    near_since: float | None = None
    lift: str = ""
    origin: str = ""
    waited: float = 0.0
    entered: float = 0.0


class RideLog:
    """Watches the true places of the robots of a building.

    Parameters
    ----------
    building : SimulatedBuilding

    Attributes
    ----------
    rides : list of LoggedRide
        Rides that have ended, oldest first.
    """

    def __init__(self, building: SimulatedBuilding) -> None:
        self.rides: list[LoggedRide] = []
        self._building = building
        self._watched: list[_Watched] = []
        self._due = 0.0

    def after_step(self) -> None:
        """Look at the robots, after a step of the building."""
        now = self._building.time()
        if now < self._due:
            return
        self._due = now + PERIOD
        for _ in self._building.robots[len(self._watched) :]:
            self._watched.append(_Watched())
        for number, (robot, watched) in enumerate(zip(self._building.robots, self._watched, strict=True)):
            self._look(number, robot, watched, now)

    def _look(self, number: int, robot: SimulatedRobot, watched: _Watched, now: float) -> None:
        floor, pose = self._building.floor_of(robot), robot.base.pose
        landings = [each for places in self._building.layout.landings.values() for each in places]
        here = [each for each in landings if each.floor == floor]
        lift = next((each.lift for each in here if is_inside(each, pose)), "")
        if lift:
            self._enter(watched, lift, floor, now)
            return
        if watched.lift:
            self.rides.append(
                LoggedRide(number, watched.lift, watched.origin, floor, watched.waited, now - watched.entered, now)
            )
            watched.lift = ""
        if not any(_is_near(each, pose) for each in here):
            watched.near_since = None
        elif watched.near_since is None:
            watched.near_since = now

    @staticmethod
    def _enter(watched: _Watched, lift: str, floor: str, now: float) -> None:
        if not watched.lift:
            since = now if watched.near_since is None else watched.near_since
            watched.lift, watched.origin, watched.entered, watched.waited = lift, floor, now, now - since
        watched.near_since = None


def _is_near(landing: Landing, pose: Pose2D) -> bool:
    """Return whether a robot is before a lift, or in its doorway."""
    return min(math.dist(landing.wait[:2], pose[:2]), math.dist(landing.door.middle, pose[:2])) < NEAR
