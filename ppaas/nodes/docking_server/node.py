"""Node ``docking_server``: serves Nav2's actions ``dock_robot`` and ``undock_robot``."""

import math
from collections.abc import Callable, Mapping
from typing import ClassVar

import msgspec

from ppaas.costmap.map_layers import MapLayers
from ppaas.decoding import from_json
from ppaas.docking.approach import BodyOutline
from ppaas.docking.charge import ChargeReading
from ppaas.docking.dock import MappedDock, docks_of
from ppaas.docking.docking import Docking
from ppaas.docking.failures import DockingFailure, DockTypeUnknown
from ppaas.docking.parameters import DockingParameters
from ppaas.docking.targets import DockTarget, DockTargets
from ppaas.docking.undocking import Undocking
from ppaas.errors import PPaaSError
from ppaas.messages.actionlib_msgs import GoalID, Status
from ppaas.messages.base.std_msgs import Bool, Duration
from ppaas.messages.geometry_msgs import PoseStamped
from ppaas.messages.health.stops import StopState
from ppaas.messages.move_base_msgs import MoveBaseActionResult
from ppaas.messages.nav2_servers import (
    DockError,
    DockRobotActionGoal,
    DockRobotFeedback,
    DockRobotResult,
    UndockRobotActionGoal,
    UndockRobotResult,
)
from ppaas.messages.operators.teleoperation import TeleopState
from ppaas.messages.sensor_msgs import BatteryState, LaserScan
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.navigation.action_goals import GoalList
from ppaas.navigation.events import CancelReceived
from ppaas.nodes import topics
from ppaas.nodes.action_publisher import ActionPublisher
from ppaas.nodes.base import Context, Node, Payload, Topic
from ppaas.nodes.docking_server.carried import CarriedLoad
from ppaas.nodes.docking_server.docked import DockedRobot
from ppaas.nodes.docking_server.driving import PREFIX, DockingDriver, DockingEnd
from ppaas.nodes.docking_server.goals import (
    OTHER_GOALS,
    PHASES,
    DockedAt,
    DockGoal,
    DockingState,
    UndockGoal,
    dock_goal,
    undock_goal,
)
from ppaas.nodes.docking_server.senses import DockingSenses
from ppaas.nodes.frames import FrameNames
from ppaas.nodes.message_checks import expect
from ppaas.nodes.nav2_actions import DOCK_ROBOT, UNDOCK_ROBOT

STATUS_PERIOD, FEEDBACK_PERIOD = 1.0, 0.5
"""Periods of the status lists and of feedback [s]."""


class DockingServerNode(Node):
    """Docks the robot and undocks it, one goal at a time; watches the battery of a docked robot.

    Another goal for the robot ends docking, and docking ends the goals of Move Base. While the robot is stopped, or
    somebody drives it by hand, it stands, and the status gives the reason.

    Parameters
    ----------
    context : Context
        The node's context.
    parameters : DockingParameters
    targets : DockTargets
        Settings of docks.
    body : BodyOutline
    braking : float
        Deceleration of the robot [m/s²].
    layers : MapLayers, optional
        The map, with its docks; None for a robot that makes it.
    names : FrameNames, optional
        Names of the robot's frames.
    """

    name: ClassVar[str] = "docking_server"
    subscribes: ClassVar[tuple[Topic, ...]] = (
        *DOCK_ROBOT[:2], *UNDOCK_ROBOT[:2], *OTHER_GOALS, topics.MOVE_BASE_CANCEL, topics.MOVE_BASE_RESULT,
        topics.TF, topics.TF_STATIC, topics.SCAN, topics.BATTERY_STATE, topics.DETECTED_DOCK_POSE, topics.STOP_STATE,
        topics.TELEOP_STATE, topics.LIFT_STATE,
    )  # fmt: skip
    publishes: ClassVar[tuple[Topic, ...]] = (
        *DOCK_ROBOT[2:], *UNDOCK_ROBOT[2:], topics.CMD_VEL, topics.MOVE_BASE_GOAL, topics.MOVE_BASE_CANCEL,
        topics.DOCK_STATUS, topics.LIFT, topics.LOCAL_LOAD,
    )  # fmt: skip

    def __init__(
        self, context: Context, parameters: DockingParameters, targets: DockTargets, body: BodyOutline, *,
        braking: float, layers: MapLayers | None = None, names: FrameNames | None = None,
    ) -> None:  # fmt: skip
        super().__init__(context)
        self._parameters, self._targets, self._body, self._braking = parameters, targets, body, braking
        self._docks: tuple[MappedDock, ...] = () if layers is None else docks_of(layers.zones)
        self._senses = DockingSenses(names)
        self._driver = DockingDriver(context, self._senses, 1.0 / parameters.controller_frequency, self._ended)
        self._docked = DockedRobot(context, parameters.not_charging_timeout)
        self._load = CarriedLoad(context, parameters)
        self._dock_topics: ActionPublisher[DockGoal] = ActionPublisher(context, DOCK_ROBOT)
        self._undock_topics: ActionPublisher[UndockGoal] = ActionPublisher(context, UNDOCK_ROBOT)
        self._dock_goals: GoalList[DockGoal] = GoalList()
        self._undock_goals: GoalList[UndockGoal] = GoalList()
        self._counter, self._stopped, self._by_hand = 0, "", ""
        self._handlers: Mapping[str, Callable[[Payload], None]] = {
            DOCK_ROBOT.goal.name: self._on_dock, DOCK_ROBOT.cancel.name: self._on_dock_cancel,
            UNDOCK_ROBOT.goal.name: self._on_undock, UNDOCK_ROBOT.cancel.name: self._on_undock_cancel,
            topics.MOVE_BASE_CANCEL.name: self._on_move_base_cancel, topics.MOVE_BASE_RESULT.name: self._on_result,
            topics.SCAN.name: self._on_scan, topics.BATTERY_STATE.name: self._on_battery,
            topics.DETECTED_DOCK_POSE.name: self._on_pose, topics.STOP_STATE.name: self._on_stop,
            topics.TELEOP_STATE.name: self._on_teleop, topics.LIFT_STATE.name: self._on_lift,
        } | {topic.name: self._on_other_goal for topic in OTHER_GOALS}  # fmt: skip

    @property
    def busy(self) -> bool:
        """Whether a goal is active."""
        return self._driver.runs

    def use_layers(self, layers: MapLayers) -> None:
        """Use the docks of another map in the same frame, for later goals."""
        self._docks = docks_of(layers.zones)

    def start(self) -> None:
        """Start publishing status and feedback, and watching a docked robot."""
        self.context.every(STATUS_PERIOD, self._publish_statuses)
        self.context.every(FEEDBACK_PERIOD, self._feed_back)

    def _publish_statuses(self) -> None:
        self._dock_topics.status(self._dock_goals)
        self._undock_topics.status(self._undock_goals)
        self._docked.look(None if self._docked.at is None else self._senses.odometry())

    # -- the robot -----------------------------------------------------------------------------------------------------

    def on_message(self, topic: str, message: Payload) -> None:
        """Handle a message.

        Raises
        ------
        InvalidInput
            A number is not finite, or a pose has no frame.
        TransformError
            A frame is unknown.
        """
        if isinstance(message, TFMessage):
            now, stamp = self.context.elapsed(), self.context.now()
            self._senses.hear(topic, message, now, stamp, at_once=self._driver.runs)
        else:
            self._handlers[topic](message)

    def _on_scan(self, message: Payload) -> None:
        if self._driver.runs:
            self._senses.take_scan(expect(message, LaserScan), self.context.elapsed())

    def _on_pose(self, message: Payload) -> None:
        if self._driver.runs:
            self._senses.take_pose(expect(message, PoseStamped), self.context.elapsed())

    def _on_battery(self, message: Payload) -> None:
        state, now = expect(message, BatteryState), self.context.elapsed()
        reading = ChargeReading(now, _finite(state.current), _finite(state.percentage), state.power_supply_status)
        self._driver.take(reading)
        self._docked.take(reading)

    def _on_lift(self, message: Payload) -> None:
        self._senses.lifted = expect(message, Bool).data
        if self._driver.docking is None:
            self._note_load()

    def _note_load(self) -> None:
        """Take what the lift has reported; where a load was set down is the end of the text of the goal."""
        if not self._load.note(self._senses.lifted):
            return
        self._docked.carries = self._load.report
        self._docked.report()
        active, robot = self._undock_goals.active, self._senses.robot_in_map()
        if active is not None and robot is not None:
            placed = f"set down at ({robot.x:.2f}, {robot.y:.2f}, {robot.theta:.2f})"
            active.goal = msgspec.structs.replace(active.goal, placed=placed)

    def _on_stop(self, message: Payload) -> None:
        self._stopped = expect(message, StopState).text
        self._driver.held = self._stopped or self._by_hand

    def _on_teleop(self, message: Payload) -> None:
        state = expect(message, TeleopState)
        self._by_hand = f"{state.driver or state.id} drives the robot by hand" if state.id else ""
        self._driver.held = self._stopped or self._by_hand

    def _on_result(self, message: Payload) -> None:
        self._driver.take_result(expect(message, MoveBaseActionResult))

    # -- goals ---------------------------------------------------------------------------------------------------------

    def _id_of(self, goal_id: GoalID) -> tuple[str, float]:
        """Return the id and the stamp of a goal."""
        stamp = goal_id.stamp.seconds() or self.context.now()
        self._counter += 1
        return goal_id.id or f"{self.name}-{self._counter}-{stamp:.3f}", stamp

    def _on_dock(self, message: Payload) -> None:
        request = expect(message, DockRobotActionGoal)
        name, stamp = self._id_of(request.goal_id)
        if self._dock_goals.knows(name, self.context.elapsed()):
            return
        goal, asked = DockGoal(name, stamp), request.goal
        try:
            charges = asked.use_dock_id or self._targets.type_of(asked.dock_type)[1].charges
            goal = dock_goal(name, stamp, asked, self._senses.frames.tree, charges=charges)
            targets = self._targets_of(goal)
        except PPaaSError as error:
            self._dock_goals.refuse(goal, self.context.elapsed(), str(error))
            self._publish_dock_end(goal, DockingEnd(Status.ABORTED, str(error), _code_of(error)), 0)
            return
        self._end_all(f"Replaced by another goal: {name}")
        if goal.place is None and self._docked.is_charged_at(goal.dock):
            self._dock_goals.accept(goal)
            self._ended(DockingEnd(Status.SUCCEEDED, "the robot stands there, and is charged"))
        else:
            self._begin_docking(goal, targets)

    def _targets_of(self, goal: DockGoal) -> list[DockTarget]:
        if goal.place is not None:
            return [self._targets.target(goal.place)]
        loaded = self._load.load is not None
        return self._targets.named(goal.dock, self._docks, self._senses.robot_in_map(), loaded=loaded)

    def _begin_docking(self, goal: DockGoal, targets: list[DockTarget]) -> None:
        self._docked.dock(None)
        self._dock_goals.accept(goal)
        machine = Docking(
            targets, self._parameters, self._body, braking=self._braking, now=self.context.elapsed(),
            navigate=goal.navigate, staging_time=goal.staging_time,
        )  # fmt: skip
        self._driver.run(machine, goal.seconds)
        self._publish_statuses()

    def _on_undock(self, message: Payload) -> None:
        request = expect(message, UndockRobotActionGoal)
        name, stamp = self._id_of(request.goal_id)
        if self._undock_goals.knows(name, self.context.elapsed()):
            return
        goal = UndockGoal(name, stamp)
        try:
            goal = undock_goal(name, stamp, request.goal)
            kind = goal.dock_type or self._type_here()
            self._targets.type_of(kind)
            goal = msgspec.structs.replace(goal, dock_type=kind, start=self._senses.frames.odometry())
        except PPaaSError as error:
            self._undock_goals.refuse(goal, self.context.elapsed(), str(error))
            self._publish_undock_end(goal, DockingEnd(Status.ABORTED, str(error), _code_of(error)))
            return
        self._end_all(f"Replaced by another goal: {name}")
        self._begin_undocking(goal)

    def _type_here(self) -> str:
        """Return the type of the dock at which the robot stands, or sets down what it carries."""
        if self._load.load is not None:
            return self._load.load.dock_type
        if self._docked.at is None and len(self._parameters.dock_types) > 1:
            raise DockTypeUnknown("it is not known at which dock the robot stands: name its dock_type")
        return "" if self._docked.at is None else self._docked.at.dock.type

    def _begin_undocking(self, goal: UndockGoal) -> None:
        assert goal.start is not None, "a goal to undock knows where it began"
        self._undock_goals.accept(goal)
        until = self.context.elapsed() + goal.allowance - goal.seconds
        _, kind = self._targets.type_of(goal.dock_type)
        machine = Undocking(
            goal.start, kind, self._parameters, self._body, braking=self._braking, until=until,
            loaded=self._load.load is not None,
        )  # fmt: skip
        self._driver.run(machine, goal.seconds)
        self._publish_statuses()

    def _feed_back(self) -> None:
        active, docking = self._dock_goals.active, self._driver.docking
        if active is None or docking is None:
            return
        active.text = docking.text
        spent = Duration.of(self._driver.seconds)
        feedback = DockRobotFeedback(int(PHASES[docking.phase]), spent, docking.retries)
        self._dock_topics.feedback(active.goal, feedback, docking.text)

    # -- cancels, and goals of others ----------------------------------------------------------------------------------

    def _on_dock_cancel(self, message: Payload) -> None:
        if self._dock_goals.cancelled_by(self._cancel_of(message)):
            self._end_all("The goal was cancelled.")

    def _on_undock_cancel(self, message: Payload) -> None:
        if self._undock_goals.cancelled_by(self._cancel_of(message)):
            self._end_all("The goal was cancelled.")

    def _on_move_base_cancel(self, message: Payload) -> None:
        """End for a cancel of all goals, which stops the robot, but not for this node's."""
        if self._driver.is_stopped_by(self._cancel_of(message)):
            self._end_all("The goal was cancelled.")

    def _cancel_of(self, message: Payload) -> CancelReceived:
        cancel = expect(message, GoalID)
        return CancelReceived(self.context.elapsed(), cancel.id, cancel.stamp.seconds())

    def _on_other_goal(self, message: Payload) -> None:
        goal_id: str = getattr(message, "goal_id", GoalID()).id
        if not goal_id.startswith(PREFIX):
            self._end_all(f"Replaced by another goal: {goal_id or 'a simple goal'}")

    # -- ends ----------------------------------------------------------------------------------------------------------

    def _end_all(self, reason: str) -> None:
        """End the active goal, because the robot does something else."""
        self._ended(DockingEnd(Status.PREEMPTED, reason))
        self._driver.halt()

    def _ended(self, end: DockingEnd) -> None:
        """Publish the end of the active goal, if there is one."""
        now, docking = self.context.elapsed(), self._driver.docking
        if docking is not None:
            if docking.lift:
                self._load.expect(docking.dock, self._targets.type_of(docking.dock.type)[0])
            self._note_load()
        if self._dock_goals.active is not None:
            if end.docked is not None:
                kind = self._targets.target(end.docked.dock).type
                self._docked.dock(DockedAt(end.docked.dock, end.docked.pose), kind.charging_threshold)
            goal = self._dock_goals.end(now, end.status, end.text).goal
            self._publish_dock_end(goal, end, 0 if docking is None else docking.retries)
        if self._undock_goals.active is not None:
            if end.status is Status.SUCCEEDED:
                self._docked.dock(None)
                end = end._replace(text=end.text or self._undock_goals.active.goal.placed)
            self._publish_undock_end(self._undock_goals.end(now, end.status, end.text).goal, end)

    def _publish_dock_end(self, goal: DockGoal, end: DockingEnd, retries: int) -> None:
        succeeded = end.status is Status.SUCCEEDED
        result = DockRobotResult(succeeded, int(end.code), retries, end.text if end.code else "")
        self._dock_topics.result(goal, end.status, end.text, result)
        self._dock_topics.status(self._dock_goals)

    def _publish_undock_end(self, goal: UndockGoal, end: DockingEnd) -> None:
        succeeded = end.status is Status.SUCCEEDED
        result = UndockRobotResult(succeeded, int(end.code), end.text if end.code else "")
        self._undock_topics.result(goal, end.status, end.text, result)
        self._undock_topics.status(self._undock_goals)

    # -- checkpoints ---------------------------------------------------------------------------------------------------

    def checkpoint(self) -> bytes:
        """Return the active goal, and where the robot is docked, as JSON."""
        seconds, docking = self._driver.seconds, self._driver.docking
        dock, undock = self._dock_goals.active, self._undock_goals.active
        name = "" if docking is None else docking.dock.name
        state = DockingState(
            None if dock is None else msgspec.structs.replace(dock.goal, dock=name, seconds=seconds),
            None if undock is None else msgspec.structs.replace(undock.goal, seconds=seconds),
            self._docked.at, docking is not None and docking.drives_itself, self._counter, self._load.load,
        )  # fmt: skip
        return msgspec.json.encode(state)

    def restore(self, state: bytes) -> None:
        """Continue the goal of a checkpoint: a robot that was beyond the staging pose looks for the dock from there."""
        restored, now = from_json(state, DockingState), self.context.elapsed()
        self._counter, self._load.load = restored.counter, restored.load
        self._docked.carries = self._load.report
        if restored.docked is not None:
            kind = self._targets.target(restored.docked.dock).type
            self._docked.dock(restored.docked, kind.charging_threshold)
        if restored.dock is not None and not self._dock_goals.knows(restored.dock.id, now):
            goal = restored.dock
            if restored.near:
                goal = msgspec.structs.replace(goal, navigate=False)
            self._begin_again(goal)
        elif restored.undock is not None and not self._undock_goals.knows(restored.undock.id, now):
            self._begin_undocking(restored.undock)

    def _begin_again(self, goal: DockGoal) -> None:
        try:
            targets = self._targets_of(goal)
        except DockingFailure as error:  # the dock was taken off the map meanwhile
            self._dock_goals.refuse(goal, self.context.elapsed(), str(error))
            self._publish_dock_end(goal, DockingEnd(Status.ABORTED, str(error), error.code), 0)
            return
        self._begin_docking(goal, targets)


def _code_of(error: PPaaSError) -> DockError:
    return error.code if isinstance(error, DockingFailure) else DockError.UNKNOWN


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None
