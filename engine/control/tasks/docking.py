"""Docking of robots with tasks: trips to docks end by docking, and docked robots undock before they drive."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from engine.links.place_link import PlaceLink
from engine.specs.goal_states import STATES
from ppaas.clock import Clock, monotonic
from ppaas.errors import PPaaSError
from ppaas.messages import decode, encode
from ppaas.messages.actionlib_msgs import GoalID, GoalStatusArray, Status
from ppaas.messages.nav2_servers import (
    DockRobotActionGoal,
    DockRobotActionResult,
    DockRobotGoal,
    UndockRobotActionGoal,
    UndockRobotActionResult,
    UndockRobotGoal,
)
from ppaas.navigation.goal_watch import GoalWatch, status_of
from ppaas.nodes.nav2_actions import DOCK_ROBOT, UNDOCK_ROBOT
from ppaas.tasks.orders import Outcome

REPORTED = 10.0
"""Time after undocking until which reports may still have the robot at its dock [s]."""

_RESULTS: dict[str, type[DockRobotActionResult | UndockRobotActionResult]] = {
    DOCK_ROBOT.result.name: DockRobotActionResult,
    UNDOCK_ROBOT.result.name: UndockRobotActionResult,
}
_CANCELS = {DOCK_ROBOT.goal.name: DOCK_ROBOT.cancel.name, UNDOCK_ROBOT.goal.name: UNDOCK_ROBOT.cancel.name}
_STATUSES = {DOCK_ROBOT.status.name: DOCK_ROBOT.goal.name, UNDOCK_ROBOT.status.name: UNDOCK_ROBOT.goal.name}


@dataclass(frozen=True, slots=True)
class DockingGoal:
    """Goal that ends by docking, or that begins by undocking and has not left the dock."""

    id: str
    state: Literal["pending", "active"] | Outcome
    text: str = ""


@dataclass(slots=True)
class _Sent:
    """Goal of an action, named by its topic for goals; ``then`` is done once it has succeeded."""

    action: str
    watch: GoalWatch
    then: Callable[[], object] | None = None
    sequence: int = 0


class DockingClient:
    """Client of a robot's place that docks and undocks it, and follows who else does.

    Parameters
    ----------
    place : PlaceLink
    goal_ended : callable
        Called once a goal has ended.
    monotonic : callable
        Returns monotonic time [s].
    """

    def __init__(
        self, place: PlaceLink, goal_ended: Callable[[], None] = lambda: None, *, monotonic: Clock = monotonic
    ) -> None:
        self._place, self._goal_ended, self._monotonic = place, goal_ended, monotonic
        self._client: int | None = None
        self._sent: dict[str, _Sent] = {}
        self._goals: dict[str, DockingGoal] = {}
        self._undocked_at = -math.inf
        self._followed: dict[str, frozenset[str]] = {}
        if self.can_dock:
            self._join()

    def leave(self) -> None:
        """Leave the place."""
        if self._client is not None:
            self._place.leave(self._client)

    @property
    def can_dock(self) -> bool:
        """Whether its clone docks; one of an earlier release does not."""
        return DOCK_ROBOT.goal.name in self._place.topics

    @property
    def is_docked(self) -> bool:
        """Whether the robot stands at a dock, by the last report of its container."""
        return bool(self._place.beat.report.docked) and self._monotonic() - self._undocked_at > REPORTED

    @property
    def followed(self) -> frozenset[str]:
        """Ids of the goals to dock and to undock that the robot follows, no matter who sent them."""
        return frozenset().union(*self._followed.values())

    def stands_at(self, name: str) -> bool:
        """Return whether the robot stands at the dock of a name."""
        return self.is_docked and f"dock {name!r}" in self._place.beat.report.docked

    def goals(self) -> list[DockingGoal]:
        """Return the goals that were sent, oldest first."""
        return list(self._goals.values())

    def dock(self, goal_id: str, name: str) -> None:
        """Send a robot to a dock, unless the goal was sent."""
        if goal_id not in self._goals:
            goal = DockRobotActionGoal(goal=DockRobotGoal(dock_id=name), goal_id=GoalID(id=goal_id))
            self._send(DOCK_ROBOT.goal.name, goal_id, encode(goal))

    def undock(self, goal_id: str, then: Callable[[], object]) -> None:
        """Undock a robot, and do something then; if it does not undock, the goal of this id has failed."""
        if goal_id in self._sent:
            self._sent[goal_id].then = then
        elif goal_id not in self._goals:
            goal = UndockRobotActionGoal(goal=UndockRobotGoal(), goal_id=GoalID(id=goal_id))
            self._send(UNDOCK_ROBOT.goal.name, goal_id, encode(goal), then)

    def cancel(self, goal_id: str) -> None:
        """Cancel a goal that was sent here, or by another master before."""
        actions = {_STATUSES[topic] for topic, followed in self._followed.items() if goal_id in followed}
        actions |= {self._sent[goal_id].action} if goal_id in self._sent else set()
        for action in sorted(actions):
            self._place.deliver(_CANCELS[action], encode(GoalID(id=goal_id)), self._join(), must_arrive=True)

    def _join(self) -> int:
        if self._client is None:
            self._client = self._place.join(self)
            for topic in (*_RESULTS, *_STATUSES):
                self._place.subscribe(topic, self._client)
        return self._client

    def _send(self, action: str, goal_id: str, goal: bytes, then: Callable[[], object] | None = None) -> None:
        client = self._join()
        sent = _Sent(action, GoalWatch(goal_id), then)
        sent.sequence = self._place.deliver(action, goal, client, must_arrive=True)
        # Robots have one goal at a time: what has ended before was noted.
        self._goals = {name: one for name, one in self._goals.items() if name in self._sent}
        self._sent[goal_id], self._goals[goal_id] = sent, DockingGoal(goal_id, "pending")

    # -- from the place ------------------------------------------------------------------------------------------------

    def published(self, topic: str, payload: bytes) -> None:
        """Handle a message of a subscribed topic."""
        if topic in _RESULTS:
            status = decode(_RESULTS[topic], payload).status
            if status.goal_id.id in self._sent:
                self._update(status.goal_id.id, status_of(status), status.text)
        elif topic in _STATUSES:
            listed, now = decode(GoalStatusArray, payload).status_list, self._monotonic()
            open_now = (status for status in listed if not Status(status.status).terminal)
            self._followed[topic] = frozenset(status.goal_id.id for status in open_now)
            for goal_id, sent in tuple(self._sent.items()):
                if sent.action == _STATUSES[topic]:
                    end = sent.watch.see(listed, now)
                    self._update(goal_id, end or sent.watch.status, sent.watch.text)

    def _update(self, goal_id: str, status: Status, text: str) -> None:
        if not status.terminal:
            self._goals[goal_id] = DockingGoal(goal_id, STATES[status], text)
            return
        sent = self._sent.pop(goal_id)
        if sent.action == UNDOCK_ROBOT.goal.name and status is Status.SUCCEEDED:
            self._undocked_at = self._monotonic()
        if sent.then is None:
            self._goals[goal_id] = DockingGoal(goal_id, STATES[status], text)
        elif status is Status.SUCCEEDED:
            del self._goals[goal_id]
            self._go_on(goal_id, sent.then)
        else:
            self._goals[goal_id] = DockingGoal(goal_id, STATES[status], f"it did not undock: {text}")
        self._goal_ended()

    def _go_on(self, goal_id: str, then: Callable[[], object]) -> None:
        try:
            then()
        except PPaaSError as error:
            self._goals[goal_id] = DockingGoal(goal_id, "aborted", str(error))

    def refused(self, topic: str, error: PPaaSError, sequence: int) -> None:
        """End a goal that the clone refused."""
        for goal_id, sent in tuple(self._sent.items()):
            if sent.sequence == sequence and sent.action == topic:
                self._update(goal_id, Status.REJECTED, str(error))

    def acknowledged(self, sequence: int) -> None:
        """Ignore that messages are in a checkpoint; they are sent again until they are."""

    def closed(self, reason: PPaaSError) -> None:
        """End all goals with the place."""
        for goal_id in tuple(self._sent):
            self._update(goal_id, Status.LOST, str(reason))
