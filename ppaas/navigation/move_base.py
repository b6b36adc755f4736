"""State machine of Move Base: takes events and returns orders; an oscillation check watches the robot.

States, patience and recoveries are the same as in ``move_base.cpp`` (ros-planning/navigation)::

    goal ──► PLANNING ──plan──► CONTROLLING ──at the goal──► SUCCEEDED
               ▲  │                 │  │
               │  │ planner_patience│  │ no velocity: plan again (PLANNING)
               │  ▼                 ▼  ▼ controller_patience, oscillation
               └─CLEARING◄──────────┘
                   └── no recovery is left ──► ABORTED

It differs:

- A planning error that no recovery can change (``PlanFailed.final``) aborts the goal at once with its reason.
- A plan that cannot be renewed while the robot follows it is given up after planner_patience, since the path is
  blocked; move_base would drive up to the obstacle.
- While the robot's pose is unknown or a plan is deferred, the robot stands, and patience does not run out.
- If the base does not follow commands, the robot stands and tries again at intervals; recovery begins after
  controller_patience.
- A goal that brings its path (``follow_path`` of Nav2) has no recovery behaviours, as in Nav2's controller server.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum

from ppaas.controllers.base import Velocity
from ppaas.geometry import Pose2D, Poses
from ppaas.messages.actionlib_msgs import Status
from ppaas.navigation.action_goals import GoalList
from ppaas.navigation.events import (
    CancelReceived,
    ControlFailed,
    ControlTick,
    Event,
    Goal,
    GoalMoved,
    GoalReceived,
    GoalUpdated,
    Held,
    PlanBlocked,
    PlanDeferred,
    PlanDue,
    PlanFailed,
    PlanSucceeded,
    PosesPassed,
    Preempted,
    RecoveryEnded,
    RecoveryStepped,
    VelocityComputed,
)
from ppaas.navigation.parameters import MoveBaseParameters
from ppaas.navigation.progress_checker import ProgressFailure
from ppaas.plans.stored import Origin

# -- orders of Move Base's state machine, which the node executes one after the other ----------------------------------


@dataclass(frozen=True, slots=True)
class RequestPlan:
    """Plan from the robot's pose through poses to a goal.

    Answer with ``PlanSucceeded``, ``PlanFailed`` or ``PlanDeferred``, now or later.
    """

    number: int
    goal: Pose2D
    through: tuple[Pose2D, ...] = ()


@dataclass(frozen=True, slots=True)
class CancelPlan:
    """Cancel the plan of this number; no answer is needed."""

    number: int


@dataclass(frozen=True, slots=True)
class FollowPlan:
    """Pass this plan (n, 7) to the local planner."""

    poses: Poses


@dataclass(frozen=True, slots=True)
class ComputeVelocity:
    """Compute a velocity with the local planner; answer with ``VelocityComputed`` or ``ControlFailed``."""

    pose: Pose2D


@dataclass(frozen=True, slots=True)
class SendVelocity:
    """Send a velocity to the base."""

    velocity: Velocity


@dataclass(frozen=True, slots=True)
class StopBase:
    """Stop the base."""


@dataclass(frozen=True, slots=True)
class Recover:
    """Run one cycle of a recovery behaviour; answer with ``RecoveryStepped`` or ``RecoveryEnded``.

    Parameters
    ----------
    index : int
        Index of the behaviour in the list, from 0.
    pose : Pose2D
        Pose of the robot in the map frame.
    begin : bool
        Whether this is the first cycle of a run.
    """

    index: int
    pose: Pose2D
    begin: bool


@dataclass(frozen=True, slots=True)
class PublishGoal:
    """Publish the goal that the robot now drives to; ``updated`` if it is the goal of before at another pose."""

    goal: Goal
    updated: bool = False


@dataclass(frozen=True, slots=True)
class PublishStatus:
    """Publish the status list, since the status of a goal or its text has changed."""


@dataclass(frozen=True, slots=True)
class PublishFeedback:
    """Publish the robot's pose, and the number of recoveries begun so far, as feedback of the active goal."""

    goal: Goal
    pose: Pose2D
    recoveries: int = 0


@dataclass(frozen=True, slots=True)
class PublishResult:
    """Publish the result of a goal that has ended; there is exactly one for each goal received.

    Parameters
    ----------
    cause : Trigger, optional
        What was tried in vain, of a goal that is aborted after all recovery behaviours.
    """

    goal: Goal
    status: Status
    text: str
    cause: "Trigger | None" = None


Order = (
    RequestPlan
    | CancelPlan
    | FollowPlan
    | ComputeVelocity
    | SendVelocity
    | StopBase
    | Recover
    | PublishGoal
    | PublishStatus
    | PublishFeedback
    | PublishResult
)


# -- oscillation check -------------------------------------------------------------------------------------------------


class Oscillation:
    """Measures how long a robot has stayed within a distance of one place.

    Parameters
    ----------
    distance : float
        Distance at which it has left the place [m].
    timeout : float
        Time for which it may stay [s]; 0 means forever.
    """

    def __init__(self, distance: float, timeout: float) -> None:
        self._distance = distance
        self._timeout = timeout
        self._place: Pose2D | None = None
        self._since = 0.0

    def reset(self, now: float) -> None:
        """Restart the timeout."""
        self._since = now

    def has_left(self, now: float, pose: Pose2D) -> bool:
        """Update the robot's pose; return whether it has left its last place."""
        if self._place is not None and pose.distance_to(self._place) < self._distance:
            return False
        self._place = pose
        self._since = now
        return True

    def timed_out(self, now: float) -> bool:
        """Return whether it has stayed longer than the timeout."""
        return self._timeout > 0.0 and now - self._since > self._timeout


# -- the state machine: events in, orders out --------------------------------------------------------------------------

GOAL_REACHED = "Goal reached."
CANCELLED = "The goal was cancelled."
NO_PLAN = "Failed to find a valid plan."
EVEN_AFTER = " Even after executing recovery behaviors."


class GoalPhase(Enum):
    """What Move Base does for the active goal."""

    PLANNING = "planning"
    CONTROLLING = "controlling"
    CLEARING = "clearing"


class Trigger(Enum):
    """Reason for recovery; its value is the text with which the goal is aborted when no recovery is left."""

    PLANNING = f"Failed to find a valid plan.{EVEN_AFTER}"
    CONTROLLING = f"Failed to find a valid control.{EVEN_AFTER}"
    OSCILLATION = f"Robot is oscillating.{EVEN_AFTER}"
    NO_PROGRESS = f"Robot does not follow cmd_vel.{EVEN_AFTER}"


STUCK = frozenset({Trigger.OSCILLATION, Trigger.NO_PROGRESS})
"""Triggers of which the robot has recovered as soon as it has moved away."""


class MoveBase:
    """Drives a robot to one goal at a time.

    Parameters
    ----------
    parameters : MoveBaseParameters
        Named as in move_base.
    recoveries : sequence of str
        Names of the recovery behaviours, in the order in which they are tried.
    """

    def __init__(self, parameters: MoveBaseParameters, recoveries: Sequence[str] = ()) -> None:
        self.parameters = parameters
        self.goals: GoalList[Goal] = GoalList()
        self.state = GoalPhase.PLANNING
        self._orders: list[Order] = []
        self._moving = False
        self._number = 0
        self._pending: int | None = None
        self._next_plan = 0.0
        self._plan_due = False
        self._deferred = ""
        self._last_valid_plan = 0.0
        self._last_valid_control = 0.0
        self._retries = 0
        self._origin: Origin = "computed"
        self._origins: Counter[Origin] = Counter()
        self._oscillation = Oscillation(parameters.oscillation_distance, parameters.oscillation_timeout)
        self._recoveries = tuple(recoveries)
        self._recovery_index = 0
        self._recovery_begins = False
        self._recoveries_begun = 0
        self._trigger = Trigger.PLANNING

    def handle(self, event: Event) -> list[Order]:
        """Handle an event and return the resulting orders in sequence."""
        self._orders = []
        match event:
            case GoalReceived():
                self._on_goal(event)
            case CancelReceived() if self.goals.cancelled_by(event):
                self._end(event.now, Status.PREEMPTED, CANCELLED)
            case Preempted() if self.goals.active is not None:
                self._end(event.now, Status.PREEMPTED, event.reason)
            case GoalMoved() if self.goals.active is not None:
                self._on_goal_moved(event)
            case GoalUpdated() if self.goals.active is not None:
                self._on_goal_updated(event)
            case PlanBlocked() if self.goals.active is not None and self.state is GoalPhase.CONTROLLING:
                self._plan_again(event.now)
            case Held() if self.goals.active is not None:
                self._plan_again(event.now)
            case PlanDue():
                self._next_plan, self._plan_due = event.now, True
            case _ if self.goals.active is not None:
                self._on_progress(event)
        return self._orders

    def _on_progress(self, event: Event) -> None:
        """Handle an event of the active goal; events that no longer fit the state are dropped."""
        match event:
            case ControlTick():
                self._on_tick(event)
            case PlanSucceeded():
                self._on_plan(event)
            case PlanFailed():
                self._on_no_plan(event)
            case PlanDeferred():
                self._on_plan_deferred(event)
            case PosesPassed():
                self._on_passed(event)
            case VelocityComputed() if self.state is GoalPhase.CONTROLLING:
                self._on_velocity(event)
            case ControlFailed() if self.state is GoalPhase.CONTROLLING:
                self._on_no_velocity(event)
            case RecoveryStepped() if self.state is GoalPhase.CLEARING:
                self._send(event.velocity)
            case RecoveryEnded() if self.state is GoalPhase.CLEARING:
                self._recovered(event)

    # -- goals ---------------------------------------------------------------------------------------------------------

    def _on_goal(self, event: GoalReceived) -> None:
        now, goal = event.now, event.goal
        if self.goals.knows(goal.id, now):
            return
        if self.goals.active is not None:
            self._finish(now, Status.PREEMPTED, f"Replaced by another goal: {goal.id}")
        self.goals.accept(goal)
        self._origins.clear()
        self._recovery_index = self._recoveries_begun = 0
        self._last_valid_control = now
        self._oscillation.reset(now)
        self._restart_planning(now)
        self._orders += [PublishGoal(goal), PublishStatus()]

    def _end(self, now: float, status: Status, text: str, cause: Trigger | None = None) -> None:
        self._finish(now, status, text, cause)
        self._stop()

    def _finish(self, now: float, status: Status, text: str, cause: Trigger | None = None) -> None:
        self._cancel_plan()
        ended = self.goals.end(now, status, text)
        self._orders += [PublishResult(ended.goal, status, text, cause), PublishStatus()]

    def _say(self, text: str) -> None:
        active = self.goals.active
        if active is not None and active.text != text:
            active.text = text
            self._orders.append(PublishStatus())

    def _on_goal_moved(self, event: GoalMoved) -> None:
        """Drive to where the goal is now, by the next plan; a path of a client stays as it is."""
        active = self.goals.active
        assert active is not None
        if active.goal.path:
            return
        active.goal = replace(active.goal, pose=event.pose, through=event.through)
        if self.state is GoalPhase.CONTROLLING and self.parameters.planner_frequency == 0.0:
            self._plan_again(event.now)

    def _on_goal_updated(self, event: GoalUpdated) -> None:
        """Plan to where the goal is now, while the robot drives on along the plan it has: Nav2's GoalUpdater."""
        active = self.goals.active
        assert active is not None
        if event.pose != active.goal.pose:
            self._next_plan, self._plan_due = event.now, True
        active.goal = replace(active.goal, pose=event.pose, speed_limit=event.speed_limit)
        self._orders.append(PublishGoal(active.goal, updated=True))

    def _on_passed(self, event: PosesPassed) -> None:
        if (active := self.goals.active) is not None:
            active.goal = active.goal.without_next(event.count)

    # -- the control cycle ---------------------------------------------------------------------------------------------

    def _on_tick(self, event: ControlTick) -> None:
        if event.pose is None:
            self._wait(event)
            return
        active = self.goals.active
        assert active is not None
        self._orders.append(PublishFeedback(active.goal, event.pose, self._recoveries_begun))
        left = self._oscillation.has_left(event.now, event.pose)
        # A motion by a recovery behaviour does not mean that the robot has recovered.
        if left and self._trigger in STUCK and self.state is not GoalPhase.CLEARING:
            self._recovery_index = 0
        match self.state:
            case GoalPhase.PLANNING:
                self._pause(self._deferred or "planning")
                self._request_plan(event.now)
            case GoalPhase.CONTROLLING if event.no_progress is not None:
                self._stand(event.now, event.no_progress)
            case GoalPhase.CONTROLLING:
                self._control(event.now, event.pose)
            case GoalPhase.CLEARING:
                self._orders.append(Recover(self._recovery_index, event.pose, self._recovery_begins))
                self._recovery_begins = False

    def _wait(self, event: ControlTick) -> None:
        """Stand still until the pose is known again, and restart patience since nothing was tried."""
        self._restart_patience(event.now)
        self._pause(f"waiting: {event.reason}")

    def _stand(self, now: float, why: ProgressFailure) -> None:
        """Stand still, since the base does not follow commands; recover after controller_patience."""
        if now > why.since + self.parameters.controller_patience:
            self._recover(now, Trigger.NO_PROGRESS, why.reason)
            return
        self._last_valid_control = now
        self._pause(f"waiting: {why.reason}")

    def _pause(self, text: str) -> None:
        self._say(text)
        self._rest()

    def _restart_patience(self, now: float) -> None:
        """Count planner_patience, controller_patience and oscillation_timeout from now on."""
        self._last_valid_plan = self._last_valid_control = now
        self._oscillation.reset(now)

    def _control(self, now: float, pose: Pose2D) -> None:
        self._say(f"controlling: the plan was {self._origin}")
        if self._oscillation.timed_out(now):
            self._recover(now, Trigger.OSCILLATION)
            return
        if self.parameters.planner_frequency > 0.0 or self._plan_due:
            self._request_plan(now)
        self._orders.append(ComputeVelocity(pose))

    def _on_velocity(self, event: VelocityComputed) -> None:
        if event.goal_reached:
            self._end(event.now, Status.SUCCEEDED, f"{GOAL_REACHED} {self._origins_text()}")
            return
        self._last_valid_control = event.now
        if self._trigger is Trigger.CONTROLLING:
            self._recovery_index = 0
        self._send(event.velocity)

    def _origins_text(self) -> str:
        """Return how many plans to the goal were computed and reused."""
        return f"Plans: {', '.join(f'{count} {origin}' for origin, count in sorted(self._origins.items()))}."

    def _on_no_velocity(self, event: ControlFailed) -> None:
        if event.final:
            self._end(event.now, Status.ABORTED, event.reason)
        elif event.now > self._last_valid_control + self.parameters.controller_patience:
            self._recover(event.now, Trigger.CONTROLLING)
        else:
            self._plan_again(event.now)

    def _plan_again(self, now: float) -> None:
        """Stand still until there is another plan."""
        self._cancel_plan()
        self._restart_planning(now)
        self._stop()

    def _send(self, velocity: Velocity) -> None:
        self._moving = True
        self._orders.append(SendVelocity(velocity))

    def _rest(self) -> None:
        if self._moving:
            self._stop()

    def _stop(self) -> None:
        self._moving = False
        self._orders.append(StopBase())

    # -- plans ---------------------------------------------------------------------------------------------------------

    def _restart_planning(self, now: float) -> None:
        self.state = GoalPhase.PLANNING
        self._last_valid_plan = now
        self._retries, self._deferred = 0, ""
        self._next_plan = now

    def _request_plan(self, now: float) -> None:
        active = self.goals.active
        if self._pending is not None or now < self._next_plan or active is None:
            return
        self._number += 1
        self._pending, self._plan_due = self._number, False
        frequency = self.parameters.planner_frequency
        self._next_plan = now + 1.0 / frequency if frequency > 0.0 else now
        self._orders.append(RequestPlan(self._number, active.goal.pose, active.goal.through))

    def _cancel_plan(self) -> None:
        if self._pending is not None:
            self._orders.append(CancelPlan(self._pending))
            self._pending = None

    def _on_plan(self, event: PlanSucceeded) -> None:
        if event.number != self._pending:
            return
        self._pending = None
        self._last_valid_plan = event.now
        self._retries = 0
        if self._trigger is Trigger.PLANNING:
            self._recovery_index = 0
        self.state = GoalPhase.CONTROLLING
        self._origin = event.origin
        self._origins[event.origin] += 1
        self._orders.append(FollowPlan(event.poses))

    def _on_no_plan(self, event: PlanFailed) -> None:
        if event.number != self._pending:
            return
        self._pending = None
        out_of_patience = event.now > self._last_valid_plan + self.parameters.planner_patience
        if self.state is GoalPhase.PLANNING:
            if event.final:
                self._end(event.now, Status.ABORTED, f"{NO_PLAN} {event.error}", Trigger.PLANNING)
                return
            self._retries += 1
            out_of_patience |= 0 <= self.parameters.max_planning_retries < self._retries
        if out_of_patience:
            self._recover(event.now, Trigger.PLANNING, str(event.error))

    def _on_plan_deferred(self, event: PlanDeferred) -> None:
        """Stand still until there is a plan to follow: a robot that drives up to people keeps them from moving away."""
        if event.number != self._pending:
            return
        self._pending = None
        self._restart_patience(event.now)
        self.state = GoalPhase.PLANNING
        self._deferred = f"waiting: {event.reason}"

    # -- recovery ------------------------------------------------------------------------------------------------------

    def _recover(self, now: float, trigger: Trigger, reason: str = "") -> None:
        self._trigger = trigger
        active = self.goals.active
        brings_path = active is not None and bool(active.goal.path)
        if brings_path or self._recovery_index >= len(self._recoveries):
            text = trigger.value.removesuffix(EVEN_AFTER) if brings_path else trigger.value
            self._end(now, Status.ABORTED, f"{text} {reason}".rstrip(), trigger)
            return
        self._cancel_plan()
        self._stop()
        self.state = GoalPhase.CLEARING
        self._recovery_begins = True
        self._recoveries_begun += 1
        self._say(f"recovering by {self._recoveries[self._recovery_index]}{': ' if reason else ''}{reason}")

    def _recovered(self, event: RecoveryEnded) -> None:
        if event.reason:
            self._say(f"{self._recoveries[self._recovery_index]} failed: {event.reason}")
        self._recovery_index += 1
        self._oscillation.reset(event.now)
        self._restart_planning(event.now)
        self._rest()
