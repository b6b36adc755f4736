"""What Move Base wants done. Whoever runs it carries the orders out one after the other."""

from dataclasses import dataclass

from ppaas.controllers.base import Velocity
from ppaas.geometry import Pose2D, Poses
from ppaas.messages.actionlib_msgs import Status
from ppaas.navigation.events import Goal


@dataclass(frozen=True, slots=True)
class RequestPlan:
    """Plan from where the robot is; answer with ``PlanSucceeded`` or ``PlanFailed`` of this number, now or later."""

    number: int
    goal: Pose2D


@dataclass(frozen=True, slots=True)
class CancelPlan:
    """The plan of this number is no longer wanted; no answer is needed."""

    number: int


@dataclass(frozen=True, slots=True)
class FollowPlan:
    """Give this (n, 7) plan to the local planner."""

    poses: Poses


@dataclass(frozen=True, slots=True)
class ComputeVelocity:
    """Ask the local planner; answer with ``VelocityComputed`` or ``ControlFailed``."""

    pose: Pose2D


@dataclass(frozen=True, slots=True)
class SendVelocity:
    """Tell the base to move."""

    velocity: Velocity


@dataclass(frozen=True, slots=True)
class Stop:
    """Tell the base to stand still."""


@dataclass(frozen=True, slots=True)
class Recover:
    """Run the recovery behaviour of this place in the list; answer with ``RecoveryStepped`` or ``RecoveryEnded``.

    Parameters
    ----------
    index : int
        From 0.
    pose : Pose2D
        Of the robot.
    begin : bool
        Whether this is the first cycle of a run.
    """

    index: int
    pose: Pose2D
    begin: bool


@dataclass(frozen=True, slots=True)
class PublishGoal:
    """Publish what is now headed for."""

    goal: Goal


@dataclass(frozen=True, slots=True)
class PublishStatus:
    """The status of a goal, or its text, has changed."""


@dataclass(frozen=True, slots=True)
class PublishFeedback:
    """Publish where the robot is on its way to the active goal."""

    goal: Goal
    pose: Pose2D


@dataclass(frozen=True, slots=True)
class PublishResult:
    """The goal has ended; there is exactly one for each goal that was received."""

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
