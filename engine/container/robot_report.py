"""Collects what a container reports of its robot: pose, goal, battery and software."""

import math
from collections.abc import Callable
from typing import Any

import msgspec

from engine.sessions.host import SessionHost
from engine.specs.robot_report import StateReport
from engine.specs.work_counts import FOLLOWED
from ppaas.errors import PPaaSError
from ppaas.messages.actionlib_msgs import GoalStatus, GoalStatusArray, Status
from ppaas.messages.base.std_msgs import String
from ppaas.messages.explore_msgs import ExploreActionFeedback
from ppaas.messages.geometry_msgs import PoseWithCovarianceStamped
from ppaas.messages.move_base_msgs import MoveBaseActionResult
from ppaas.nodes import topics
from ppaas.nodes.base import Payload
from ppaas.nodes.docking_server.driving import PREFIX
from ppaas.nodes.graph import Graph
from ppaas.nodes.nav2_actions import DOCK_ROBOT, EXPLORE, UNDOCK_ROBOT
from ppaas.planners.base import PlanResult

BATTERY = "battery_state"
"""Topic of the robot's client, of type ``sensor_msgs/BatteryState``, which the cloud passes on without a check."""

CONFIRM = "task/confirm"
"""Topic of a button of the robot, of type ``std_msgs/Bool``: it confirms the task that holds the robot."""

PRESSED_AGAIN = 1.0
"""Time without a message after which ``true`` is pressed again, not pressed still [s]."""

BATTERY_AGE = 60.0
"""Age from which the charge of the battery is not known any more [s]."""

EXPLORING_AGE = 5.0
"""Age of the last feedback from which a robot does not explore any more [s]."""

MOST_TEXT = 300
"""Longest text of a goal or of localization that is reported [characters]."""


_KNOWN = frozenset(map(int, Status))
_TERMINAL = frozenset(int(status) for status in Status if status.terminal)


class _BatteryState(msgspec.Struct):
    percentage: float | None = None


class _Button(msgspec.Struct):
    data: bool | None = None


_battery = msgspec.json.Decoder(_BatteryState)
_button = msgspec.json.Decoder(_Button)


class RobotReporter:
    """Reports on the robot of a container. It hears the clone, and what the client of the robot publishes beside.

    Parameters
    ----------
    graph : Graph
        Graph of the clone.
    sessions : SessionHost
        Sessions of the robot's clients.
    goal_ended : callable
        Called with the status of each goal that has ended and that the master does not follow.
    """

    def __init__(self, graph: Graph, sessions: SessionHost, goal_ended: Callable[[Status], None]) -> None:
        self._graph, self._sessions, self._goal_ended = graph, sessions, goal_ended
        self._report = StateReport()
        self._battery: tuple[float, float | None] = -math.inf, None
        self._explored: tuple[float, int] = -math.inf, 0
        self._pressed_at, self._presses = -math.inf, 0
        heard = (
            topics.AMCL_POSE, topics.AMCL_STATUS, topics.GRID_SLAM_STATUS, topics.MOVE_BASE_STATUS,
            topics.MOVE_BASE_RESULT, topics.PLAN, EXPLORE.feedback, topics.DOCK_STATUS, DOCK_ROBOT.status,
            UNDOCK_ROBOT.status,
        )  # fmt: skip
        for topic in heard:
            if topic.name in graph.topics:
                graph.tap(topic.name, self._heard)
        for name in (BATTERY, CONFIRM):
            sessions.hear(name, self)

    def report(self) -> StateReport:
        """Return what is known of the robot now."""
        now = self._graph.elapsed()
        (charged_at, battery), (explored_at, frontiers) = self._battery, self._explored
        return msgspec.structs.replace(
            self._report,
            battery=battery if now - charged_at <= BATTERY_AGE else None,
            frontiers=frontiers if now - explored_at <= EXPLORING_AGE else None,
            software=self._sessions.software,
            confirmations=self._presses,
        )

    # -- the clone -----------------------------------------------------------------------------------------------------

    def _heard(self, topic: str, payload: Payload) -> None:
        match payload:
            case PoseWithCovarianceStamped():
                pose = payload.pose.pose.planar()
                if math.isfinite(pose.x + pose.y + pose.theta):  # a node on the robot may publish anything
                    self._change(pose=(pose.x, pose.y, pose.theta), pose_at=self._graph.now())
            case String() if topic == topics.DOCK_STATUS.name:
                self._change(docked=payload.data[:MOST_TEXT])
            case String():
                self._change(localization=payload.data[:MOST_TEXT])
            case GoalStatusArray():
                for status in payload.status_list[-1:]:
                    self._goal_changed(status)
            case MoveBaseActionResult():
                self._goal_changed(payload.status)
                self._count(payload.status)
            case PlanResult():
                self._change(left=payload.length)
            case ExploreActionFeedback():
                self._explored = self._graph.elapsed(), payload.feedback.frontiers

    def _goal_changed(self, status: GoalStatus) -> None:
        # Goals of Move Base that are parts of docking say less than the goal to dock.
        if status.status not in _KNOWN or status.goal_id.id.startswith(PREFIX):
            return
        self._change(goal=int(status.status), goal_text=status.text[:MOST_TEXT])
        if status.status in _TERMINAL:
            self._change(left=None)

    def _count(self, status: GoalStatus) -> None:
        if status.status in _TERMINAL and not status.goal_id.id.startswith(FOLLOWED):
            self._goal_ended(Status(status.status))

    def _change(self, **known: Any) -> None:
        self._report = msgspec.structs.replace(self._report, **known)

    # -- the client of the robot ---------------------------------------------------------------------------------------

    def published(self, topic: str, payload: bytes) -> None:
        """Take the state of the battery, or of the button; a charge that is not a share is not known."""
        if topic == CONFIRM:
            self._press(payload)
            return
        try:
            charge = _battery.decode(payload).percentage
        except msgspec.MsgspecError:
            charge = None
        known = charge is not None and 0.0 <= charge <= 1.0
        self._battery = self._graph.elapsed(), charge if known else None

    def _press(self, payload: bytes) -> None:
        """Count a press of the button; a button that is held sends ``true`` again and again, which is one press."""
        try:
            is_down = _button.decode(payload).data is True
        except msgspec.MsgspecError:
            is_down = False
        now = self._graph.elapsed()
        self._presses += is_down and now - self._pressed_at > PRESSED_AGAIN
        self._pressed_at = now if is_down else -math.inf

    def refused(self, topic: str, error: PPaaSError, sequence: int) -> None:
        """Ignore refusals: it publishes nothing."""

    def acknowledged(self, sequence: int) -> None:
        """Ignore checkpoints: it publishes nothing."""

    def closed(self, reason: PPaaSError) -> None:
        """Ignore the end of the place, which is that of the container."""
