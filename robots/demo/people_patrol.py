"""Patrol of a robot in a demo: while it sees and follows nobody, it drives from place to place."""

import asyncio
from collections.abc import Callable

from ppaas.clock import monotonic
from ppaas.messages.people_coordination import PeopleState
from robots.client.move_base import GoalOutcome, MoveBaseClient
from robots.client.robot_client import RobotClient
from robots.sim.shortest_paths import ShortestPaths

IDLE = 2.0
"""Time without people and orders after which a robot is sent to another place [s]."""
AWAY = 5.0
"""Smallest distance to that place if the map is large enough [m]."""
PERIOD = 0.1
"""Time between two decisions [s]."""


def is_wanted(robot: str, state: PeopleState) -> bool:
    """Return whether a robot sees a person, or has an order to follow one."""
    frame = f"{robot}/"
    seen = any(name.startswith(frame) for person in state.people for name in person.seen_by)
    return seen or any(order.robot == robot for order in state.orders)


class DemoPatrol:
    """Sends a robot to random places until it sees a person, and again after that.

    A robot that has a goal of a user is not free to follow anybody, so the goal is cancelled then.

    Parameters
    ----------
    robot : str
        Robot ID.
    operator : RobotClient
        Connected client in the role of an operator of the robot.
    ways : ShortestPaths
        Places for robots.
    state : callable
        Returns the last state of the coordinator; None before the first.
    """

    def __init__(
        self, robot: str, operator: RobotClient, ways: ShortestPaths, state: Callable[[], PeopleState | None]
    ) -> None:
        self._robot, self._operator, self._ways, self._state = robot, operator, ways, state
        self._going: asyncio.Task[GoalOutcome] | None = None
        self._idle_since = monotonic()

    async def run(self) -> None:
        """Patrol until cancelled.

        Raises
        ------
        PPaaSError
            The client has failed.
        """
        move_base = await MoveBaseClient(self._operator).start()
        await move_base.localized()
        try:
            while True:
                await self._decide(move_base)
                await asyncio.sleep(PERIOD)
        finally:
            if self._going is not None:
                self._going.cancel()

    async def _decide(self, move_base: MoveBaseClient) -> None:
        state = self._state()
        if self._going is not None and self._going.done():
            self._going.result()
            self._going, self._idle_since = None, monotonic()
        if state is None or is_wanted(self._robot, state):
            if self._going is not None:
                # Not all goals of the robot: that would pause following, which may have begun.
                await move_base.cancel()
                await asyncio.wait([self._going], timeout=PERIOD)
            self._idle_since = monotonic()
        elif self._going is None and monotonic() - self._idle_since >= IDLE and move_base.estimate is not None:
            self._going = asyncio.create_task(move_base.go(self._ways.away_from(move_base.estimate, AWAY)))
