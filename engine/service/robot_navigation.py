"""Navigation of robots by REST: poses and goals, for fleet adapters and programs without a WebSocket."""

import asyncio
import contextlib

from engine.master.places import robot_key
from engine.service.links.place_link import PlaceLink
from engine.service.master_driver import MasterDriver
from engine.service.navigation_client import NavigationClient
from engine.service.views import GoalView, RobotState
from ppaas.errors import NotFound, Unavailable
from ppaas.geometry import Pose2D

POSE_TIMEOUT = 1.0
"""Time to wait for a first pose [s]: a robot that sends scans has one several times a second."""

IDLE = 300.0
"""Time after the last request after which a robot without active goals is no longer followed [s]."""


class RobotNavigation:
    """Follows the robots that REST asks for; implements ``RobotCalls``.

    Parameters
    ----------
    service : MasterDriver
        Has the links of the places.
    """

    def __init__(self, service: MasterDriver) -> None:
        self._service = service
        self._clients: dict[str, NavigationClient] = {}
        self._timers: dict[str, asyncio.TimerHandle] = {}

    def close(self) -> None:
        """Leave all places."""
        for key in tuple(self._clients):
            self._leave(key)

    async def connected(self, robots: list[tuple[str, str]]) -> list[bool | None]:
        """Return which of some robots, by user and id, are connected."""
        return [self._service.presence.is_here(robot_key(user, robot)) for user, robot in robots]

    async def state(self, user: str, robot: str) -> RobotState:
        """Return the pose and the active goals of a robot, connected or not."""
        key = robot_key(user, robot)
        place, presence = self._service.place(key), self._service.presence.of(key)
        if place is None:
            return RobotState(presence.connected, presence.disconnected_since)
        client = self._client(key, place)
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(POSE_TIMEOUT):
                await client.localized.wait()
        return client.state(presence)

    async def send_goal(self, user: str, robot: str, pose: Pose2D) -> GoalView:
        """Send a robot that is connected to a pose in the frame ``map``."""
        client = self._open(user, robot)
        if not self._service.presence.is_here(robot_key(user, robot)):
            raise _not_connected(robot)
        return client.send(pose)

    async def goals(self, user: str, robot: str) -> list[GoalView]:
        """Return the goals that REST sent to a robot since it last connected, oldest first."""
        client = self._clients.get(robot_key(user, robot))
        return client.goals() if client is not None else []

    async def goal(self, user: str, robot: str, goal_id: str) -> GoalView:
        """Return a goal; ``NotFound`` if it is unknown or forgotten."""
        client = self._clients.get(robot_key(user, robot))
        if client is None:
            raise NotFound("goal", goal_id[:64])
        return client.goal(goal_id)

    async def cancel_goal(self, user: str, robot: str, goal_id: str) -> GoalView:
        """Cancel a goal; raises as ``NavigationClient.cancel`` does."""
        await self.goal(user, robot, goal_id)
        return self._open(user, robot).cancel(goal_id)

    async def cancel_goals(self, user: str, robot: str) -> None:
        """Cancel all goals of a robot, also those of other clients; ``Unavailable`` if it has no container."""
        self._open(user, robot).cancel_all()

    def _open(self, user: str, robot: str) -> NavigationClient:
        """Return the client of a robot that has a container; it may wait for the robot."""
        key = robot_key(user, robot)
        place = self._service.place(key)
        if place is None:
            raise _not_connected(robot)
        return self._client(key, place)

    def _client(self, key: str, place: PlaceLink) -> NavigationClient:
        client = self._clients.get(key)
        if client is None or client.place is not place:
            client = self._clients[key] = NavigationClient(place)
        self._restart_timer(key)
        return client

    def _restart_timer(self, key: str) -> None:
        if key in self._timers:
            self._timers[key].cancel()
        self._timers[key] = asyncio.get_running_loop().call_later(IDLE, self._check_idle, key)

    def _check_idle(self, key: str) -> None:
        if self._clients[key].active():
            self._restart_timer(key)
        else:
            self._leave(key)

    def _leave(self, key: str) -> None:
        self._clients.pop(key).leave()
        self._timers.pop(key).cancel()


def _not_connected(robot: str) -> Unavailable:
    return Unavailable(f"robot {robot!r} is not connected: it can be sent to a goal once it is")
