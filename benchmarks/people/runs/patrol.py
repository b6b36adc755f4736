"""Patrol: a robot that sees nobody and follows nobody drives from place to place."""

from benchmarks.people.runs.robot import PeopleRobot
from ppaas.messages.people_coordination import PeopleState
from robots.demo.people_patrol import is_wanted
from robots.sim.shortest_paths import ShortestPaths

IDLE = 5.0
"""Time without people and orders after which a robot is sent to another place [s]."""
AWAY = 5.0
"""Smallest distance to that place if the map is large enough [m]."""


class Patrol:
    """Sends a robot to random places until it sees a person, and again after that.

    A robot that has a goal of a user is not free to follow anybody, so the goal is cancelled then.

    Parameters
    ----------
    robot : PeopleRobot
    ways : ShortestPaths
        Places for robots.
    """

    def __init__(self, robot: PeopleRobot, ways: ShortestPaths) -> None:
        self._robot, self._ways = robot, ways
        self._idle_since = 0.0
        self._driving = False

    def take(self, state: PeopleState, now: float) -> None:
        """Begin or end the way to a place, by the state of the coordinator at a time [s]."""
        clone = self._robot.clone
        if is_wanted(self._robot.id, state):
            # This cancels all goals, which pauses following; a patrol that has just arrived has nothing to cancel.
            if self._driving and clone.end is None:
                clone.cancel()
            self._driving, self._idle_since = False, now
        elif self._driving and clone.end is not None:
            self._driving, self._idle_since = False, now
        elif not self._driving and now - self._idle_since >= IDLE:
            self._driving = True
            clone.send_to(self._ways.away_from(self._robot.body.base.pose, AWAY))
