"""Orders of Move Base's state machine, which the node executes one after the other."""

from dataclasses import dataclass

from ppaas.controllers.base import Velocity
from ppaas.geometry import Pose2D, Poses
from ppaas.messages.actionlib_msgs import Status
from ppaas.navigation.events import Goal


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
class Stop:
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
    """Publish the result of a goal that has ended; there is exactly one for each goal received."""

    goal: Goal
    status: Status
    text: str


Order = (
    RequestPlan
    | CancelPlan
    | FollowPlan
    | ComputeVelocity
    | SendVelocity
    | Stop
    | Recover
    | PublishGoal
    | PublishStatus
    | PublishFeedback
    | PublishResult
)
