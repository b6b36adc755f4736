"""Navigation of robots by REST: poses and goals, for fleet adapters and programs without a WebSocket.

A navigation client is a client of the robot's place, as an operator's socket is. A result is lost if the container is
killed before it sends it. Move Base repeats the status of its goals, by which they are watched
(`ppaas.navigation.goal_watch`).
"""

import asyncio
import contextlib
import secrets
from collections.abc import Callable

import msgspec

from engine.control.master_driver import MasterDriver
from engine.control.views import GoalView, NavigationState, ReportedRobot
from engine.links.place_link import PlaceLink
from engine.links.presence import Presence
from engine.master.places import robot_key
from engine.specs.goal_states import STATES, GoalState
from engine.specs.robot_report import StateReport
from engine.specs.work_counts import REST_GOALS
from ppaas.clock import Clock, epoch, monotonic
from ppaas.errors import Conflict, NotFound, PPaaSError, QuotaExceeded, Unavailable
from ppaas.geometry import Pose2D
from ppaas.messages import decode, encode
from ppaas.messages.actionlib_msgs import GoalID, GoalStatusArray, Status
from ppaas.messages.base.std_msgs import Header, String
from ppaas.messages.geometry_msgs import Pose, PoseStamped, PoseWithCovarianceStamped
from ppaas.messages.move_base_msgs import MoveBaseActionGoal, MoveBaseActionResult, MoveBaseGoal
from ppaas.navigation.goal_watch import GoalWatch, status_of
from ppaas.nodes import topics
from ppaas.nodes.frames import MAP

# -- one robot ---------------------------------------------------------------------------------------------------------

MAX_ACTIVE = 32
"""Largest number of goals of a robot that have not ended."""

MAX_ENDED = 100
"""Number of ended goals that are kept; the oldest is forgotten first."""

POSE_AGE = 5.0
"""Age of the last pose from which the robot counts as not localized, whatever its clone says [s]."""

LOCALIZATION_STATUS = (topics.AMCL_STATUS, topics.GRID_SLAM_STATUS)
"""Topics of which a clone has one, the second while it makes a map."""

HEARD = (topics.AMCL_POSE, *LOCALIZATION_STATUS, topics.MOVE_BASE_STATUS, topics.MOVE_BASE_RESULT)
"""Topics that the client subscribes to."""


class NavigationClient:
    """Client of one place.

    Parameters
    ----------
    place : PlaceLink
        Place of the robot.
    clock : callable
        Returns the time [s since the epoch].
    monotonic : callable
        Returns monotonic time [s].
    goal_ended : callable
        Called with the key of the place and a goal that has ended.

    Attributes
    ----------
    place : PlaceLink
        The place.
    pose : tuple of float, optional
        Last pose: x, y [m], yaw [rad] in the frame of the map.
    followed : frozenset of str, optional
        Ids of the goals that Move Base follows or has waiting, also other clients' goals; None until it reported them.
    localized : Event
        Set once a pose was received.
    """

    def __init__(
        self,
        place: PlaceLink,
        clock: Clock = epoch,
        goal_ended: Callable[[str, GoalView], None] = lambda _key, _goal: None,
        *,
        monotonic: Clock = monotonic,
    ) -> None:
        self.place = place
        self.localized = asyncio.Event()
        self.followed: frozenset[str] | None = None
        self._clock, self._monotonic = clock, monotonic
        self._goal_ended = goal_ended
        self._goals: dict[str, GoalView] = {}
        self._sequences: dict[int, str] = {}
        self._watches: dict[str, GoalWatch] = {}
        self.pose: tuple[float, float, float] | None = None
        self._pose_at: float | None = None
        self._localization = ""
        self._client = place.join(self)
        for topic in HEARD:
            place.subscribe(topic.name, self._client)

    def leave(self) -> None:
        """Leave the place."""
        self.place.leave(self._client)

    # -- state ---------------------------------------------------------------------------------------------------------

    def state(self, presence: Presence) -> NavigationState:
        """Return the pose of the robot and its active goals, with its presence."""
        return NavigationState(
            connected=presence.connected,
            disconnected_since=presence.disconnected_since,
            container=self.place.container is not None,
            pose=self.pose,
            pose_at=self._pose_at,
            localization=self.localization,
            goals=tuple(self.active()),
        )

    @property
    def localization(self) -> str:
        """Why the pose of the robot is not renewed; empty if it is, or if none has come yet."""
        if self._localization or self._pose_at is None or self.place_now is not None:
            return self._localization
        return f"no pose has come for {self._clock() - self._pose_at:.0f} s"

    @property
    def place_now(self) -> tuple[float, float, float] | None:
        """Last pose; None before the first, and if none has come for `POSE_AGE`: then it is not where the robot is."""
        is_old = self._pose_at is None or self._clock() - self._pose_at > POSE_AGE
        return None if is_old else self.pose

    def is_newer(self, than: float) -> bool:
        """Return whether the last pose came after a time [s since the epoch]."""
        return self._pose_at is not None and self._pose_at > than

    def goals(self) -> list[GoalView]:
        """Return the known goals, oldest first."""
        return list(self._goals.values())

    def active(self) -> list[GoalView]:
        """Return the goals that have not ended, oldest first."""
        return [goal for goal in self._goals.values() if goal.ended is None]

    def goal(self, goal_id: str) -> GoalView:
        """Return a goal; ``NotFound`` if it is unknown or forgotten."""
        if goal_id not in self._goals:
            raise NotFound("goal", goal_id[:64])
        return self._goals[goal_id]

    # -- requests ------------------------------------------------------------------------------------------------------

    def send(self, pose: Pose2D, goal_id: str = "") -> GoalView:
        """Send a goal in the frame ``map``; Move Base drops the goal before it, as in ROS.

        A goal of a given id is sent once.

        Raises
        ------
        QuotaExceeded
            Too many goals have not ended, or too many messages to the clone are unacknowledged.
        """
        if goal_id in self._goals:
            return self._goals[goal_id]
        if len(self.active()) >= MAX_ACTIVE:
            raise QuotaExceeded(
                f"a robot may have at most {MAX_ACTIVE} active goals: cancel one, or wait for it to end"
            )
        now = self._clock()
        goal = GoalView(
            goal_id or f"{REST_GOALS}{secrets.token_hex(6)}", (pose.x, pose.y, pose.theta), "pending", "", now
        )
        target = MoveBaseGoal(PoseStamped(Header(frame_id=MAP), Pose.of(pose)))
        sequence = self._publish(topics.MOVE_BASE_GOAL.name, MoveBaseActionGoal(target, GoalID(id=goal.id)))
        self._sequences[sequence] = goal.id
        self._goals[goal.id], self._watches[goal.id] = goal, GoalWatch(goal.id)
        self._forget_oldest()
        return goal

    def cancel(self, goal_id: str) -> GoalView:
        """Cancel a goal and return it; it ends when Move Base reports its end.

        Raises
        ------
        NotFound
            The goal is unknown.
        Conflict
            The goal has ended.
        """
        goal = self.goal(goal_id)
        if goal.ended is not None:
            raise Conflict(f"goal {goal_id!r} has ended: {goal.state}")
        self._publish(topics.MOVE_BASE_CANCEL.name, GoalID(id=goal_id))
        return goal

    def cancel_any(self, goal_id: str) -> None:
        """Cancel a goal, also one of another client; nothing happens if Move Base does not have it."""
        self._publish(topics.MOVE_BASE_CANCEL.name, GoalID(id=goal_id))

    def cancel_all(self) -> None:
        """Cancel all goals of the robot, also other clients' goals."""
        self._publish(topics.MOVE_BASE_CANCEL.name, GoalID())

    def _publish(self, topic: str, message: MoveBaseActionGoal | GoalID) -> int:
        return self.place.deliver(topic, encode(message), self._client, must_arrive=True)

    def _forget_oldest(self) -> None:
        ended = [goal.id for goal in self._goals.values() if goal.ended is not None]
        for goal_id in ended[:-MAX_ENDED]:
            del self._goals[goal_id]

    # -- from the place ------------------------------------------------------------------------------------------------

    def published(self, topic: str, payload: bytes) -> None:
        """Handle a message of a subscribed topic."""
        if topic == topics.AMCL_POSE.name:
            pose = decode(PoseWithCovarianceStamped, payload).pose.pose.planar()
            self.pose, self._pose_at = (pose.x, pose.y, pose.theta), self._clock()
            self.localized.set()
        elif any(topic == status.name for status in LOCALIZATION_STATUS):
            self._localization = decode(String, payload).data
        elif topic == topics.MOVE_BASE_RESULT.name:
            status = decode(MoveBaseActionResult, payload).status
            if (goal := self._goals.get(status.goal_id.id)) is not None and goal.ended is None:
                self._update(goal, status_of(status), status.text)
        elif topic == topics.MOVE_BASE_STATUS.name:
            self._on_statuses(decode(GoalStatusArray, payload))

    def _on_statuses(self, statuses: GoalStatusArray) -> None:
        open_now = (status for status in statuses.status_list if not Status(status.status).terminal)
        self.followed = frozenset(status.goal_id.id for status in open_now)
        now = self._monotonic()
        for goal in self.active():
            watch = self._watches[goal.id]
            end = watch.see(statuses.status_list, now)
            self._update(goal, end or watch.status, watch.text)

    def _update(self, goal: GoalView, status: Status, text: str) -> None:
        """Note the status of a goal; a final one in a list ends it, since nothing else of its result is needed."""
        if status.terminal:
            self._end(goal, STATES[status], text)
        else:
            self._goals[goal.id] = msgspec.structs.replace(goal, state=STATES[status], text=text)

    def _end(self, goal: GoalView, state: GoalState, text: str) -> None:
        ended = self._goals[goal.id] = msgspec.structs.replace(goal, state=state, text=text, ended=self._clock())
        del self._watches[goal.id]
        self._sequences = {number: other for number, other in self._sequences.items() if other != goal.id}
        self._goal_ended(self.place.key, ended)

    def refused(self, topic: str, error: PPaaSError, sequence: int) -> None:
        """End a goal that the clone refused."""
        goal = self._goals.get(self._sequences.get(sequence, ""))
        if topic == topics.MOVE_BASE_GOAL.name and goal is not None and goal.ended is None:
            self._end(goal, "rejected", str(error))

    def acknowledged(self, sequence: int) -> None:
        """Ignore that messages are in a checkpoint; they are sent again until they are."""

    def closed(self, reason: PPaaSError) -> None:
        """End all goals with the place."""
        for goal in self.active():
            self._end(goal, "lost", str(reason))


# -- all robots --------------------------------------------------------------------------------------------------------

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
    goal_ended : callable
        Called with the key of a place and a goal that has ended.
    """

    def __init__(
        self, service: MasterDriver, goal_ended: Callable[[str, GoalView], None] = lambda _key, _goal: None
    ) -> None:
        self._service = service
        self._goal_ended = goal_ended
        self._clients: dict[str, NavigationClient] = {}
        self._timers: dict[str, asyncio.TimerHandle] = {}

    def close(self) -> None:
        """Leave all places."""
        for key in tuple(self._clients):
            self._leave(key)

    async def connected(self, robots: list[tuple[str, str]]) -> list[bool | None]:
        """Return which of some robots, by user and id, are connected."""
        return [view.connected for view in await self.views(robots)]

    async def views(self, robots: list[tuple[str, str]]) -> list[ReportedRobot]:
        """Return the states of some robots, by user and id, as their containers reported them last."""
        return [self._view(robot_key(user, robot)) for user, robot in robots]

    def _view(self, key: str) -> ReportedRobot:
        place, presence = self._service.place(key), self._service.presence.of(key)
        container = self._service.containers.of_robot(key)
        return ReportedRobot(
            presence.connected,
            presence.disconnected_since,
            None if container is None else container.state,
            "" if container is None else container.machine,
            StateReport() if place is None else place.beat.report,
        )

    async def state(self, user: str, robot: str) -> NavigationState:
        """Return the pose and the active goals of a robot, connected or not."""
        key = robot_key(user, robot)
        place, presence = self._service.place(key), self._service.presence.of(key)
        if place is None:
            return NavigationState(presence.connected, presence.disconnected_since)
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
        key = robot_key(user, robot)
        place = self._service.place(key)
        if place is None:
            raise _not_connected(robot)
        return self._client(key, place)

    def _client(self, key: str, place: PlaceLink) -> NavigationClient:
        client = self._clients.get(key)
        if client is None or client.place is not place:
            client = self._clients[key] = NavigationClient(place, goal_ended=self._goal_ended)
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
