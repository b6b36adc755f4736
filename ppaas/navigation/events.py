"""What Move Base is told. Every event carries the time [s] at which it happened, by one clock."""

from dataclasses import dataclass

from ppaas.controllers.base import Velocity
from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D, Poses
from ppaas.navigation.progress_checker import Disobedience
from ppaas.plans.stored import Origin


@dataclass(frozen=True, slots=True)
class Goal:
    """Where to go.

    Parameters
    ----------
    id : str
        Unique; a goal whose id is known already is the same goal, sent again.
    pose : Pose2D
        In the map frame.
    stamp : float
        When it was given, for cancelling "all up to then" [s].
    """

    id: str
    pose: Pose2D
    stamp: float


@dataclass(frozen=True, slots=True)
class GoalReceived:
    """A goal that can be taken came in: it takes the place of the one before."""

    now: float
    goal: Goal


@dataclass(frozen=True, slots=True)
class CancelReceived:
    """``actionlib_msgs/GoalID`` on the cancel topic: id and stamp empty mean every goal."""

    now: float
    id: str = ""
    stamp: float = 0.0


@dataclass(frozen=True, slots=True)
class PlanSucceeded:
    """The answer to the ``RequestPlan`` of that number, and where it came from."""

    now: float
    number: int
    poses: Poses
    origin: Origin = "computed"


@dataclass(frozen=True, slots=True)
class PlanFailed:
    """There is no plan for the ``RequestPlan`` of that number.

    ``final`` says that neither clearing obstacles nor turning on the spot can change it.
    """

    now: float
    number: int
    error: PPaaSError
    final: bool = False


@dataclass(frozen=True, slots=True)
class PlanDeferred:
    """There is a plan for the ``RequestPlan`` of that number, but for now it is better to wait, for this reason."""

    now: float
    number: int
    reason: str


@dataclass(frozen=True, slots=True)
class ControlTick:
    """The next control cycle.

    Parameters
    ----------
    pose : Pose2D, optional
        Of the robot in the map frame; None if it is not known well enough to move.
    reason : str
        Why not.
    disobedience : Disobedience, optional
        Why the robot is to stand though its pose is known: its base does not do what it is told.
    """

    now: float
    pose: Pose2D | None
    reason: str = ""
    disobedience: Disobedience | None = None


@dataclass(frozen=True, slots=True)
class VelocityComputed:
    """The answer to ``ComputeVelocity``; or the goal is reached, and the robot stands."""

    now: float
    velocity: Velocity
    goal_reached: bool = False


@dataclass(frozen=True, slots=True)
class ControlFailed:
    """The answer to ``ComputeVelocity``: no velocity is free of collision."""

    now: float
    reason: str = ""


@dataclass(frozen=True, slots=True)
class RecoveryStepped:
    """The answer to ``Recover``: the behaviour goes on with this velocity."""

    now: float
    velocity: Velocity


@dataclass(frozen=True, slots=True)
class RecoveryEnded:
    """The answer to ``Recover``: the behaviour is done, or was given up for this reason."""

    now: float
    reason: str = ""


Event = (
    GoalReceived
    | CancelReceived
    | PlanSucceeded
    | PlanFailed
    | PlanDeferred
    | ControlTick
    | VelocityComputed
    | ControlFailed
    | RecoveryStepped
    | RecoveryEnded
)
