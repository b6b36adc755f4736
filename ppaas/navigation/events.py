"""Events of Move Base's state machine. Each carries the time at which it happened, by one clock [s]."""

from dataclasses import dataclass, replace

from ppaas.controllers.base import Velocity
from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D, Poses
from ppaas.navigation.progress_checker import ProgressFailure
from ppaas.plans.stored import Origin


@dataclass(frozen=True, slots=True)
class Goal:
    """Goal of Move Base.

    Parameters
    ----------
    id : str
        Unique id; a goal with a known id is the same goal, sent again.
    pose : Pose2D
        In the map frame.
    stamp : float
        Time of the request, for cancels of all goals up to a time [s].
    through : tuple of Pose2D
        Poses to pass on the way, without those that were passed.
    many : bool
        Whether it is a goal of ``navigate_through_poses``.
    speed_limit : float
        Fastest speed on the way to it [m/s]; 0 for no limit.
    passed : tuple of Pose2D
        Poses on the way that were passed.
    path : tuple of Pose2D
        The path to follow, of a goal of ``follow_path``; empty if the path is planned.
    """

    id: str
    pose: Pose2D
    stamp: float
    through: tuple[Pose2D, ...] = ()
    many: bool = False
    speed_limit: float = 0.0
    passed: tuple[Pose2D, ...] = ()
    path: tuple[Pose2D, ...] = ()

    def without_next(self, count: int) -> "Goal":
        """Return the goal once the robot has passed the next poses on the way."""
        return replace(self, through=self.through[count:], passed=self.passed + self.through[:count])


@dataclass(frozen=True, slots=True)
class GoalReceived:
    """A valid goal was received; it replaces the active one."""

    now: float
    goal: Goal


@dataclass(frozen=True, slots=True)
class CancelReceived:
    """A cancel was received (``actionlib_msgs/GoalID``); with empty id and stamp it applies to every goal."""

    now: float
    id: str = ""
    stamp: float = 0.0


@dataclass(frozen=True, slots=True)
class Preempted:
    """The active goal ends, because the robot does something else for the given reason."""

    now: float
    reason: str


@dataclass(frozen=True, slots=True)
class PlanSucceeded:
    """Planning for the ``RequestPlan`` of this number succeeded; ``origin`` is computed, reused or stitched."""

    now: float
    number: int
    poses: Poses
    origin: Origin = "computed"


@dataclass(frozen=True, slots=True)
class PlanFailed:
    """Planning for the ``RequestPlan`` of this number failed.

    ``final`` means that no recovery behaviour can change that.
    """

    now: float
    number: int
    error: PPaaSError
    final: bool = False


@dataclass(frozen=True, slots=True)
class PlanDeferred:
    """There is a plan for the ``RequestPlan`` of this number, but for the given reason the robot should wait."""

    now: float
    number: int
    reason: str


@dataclass(frozen=True, slots=True)
class PlanBlocked:
    """The map was replaced, and the plan that the robot follows is blocked on the new one."""

    now: float


@dataclass(frozen=True, slots=True)
class Held:
    """The robot is stopped, or released again, perhaps elsewhere: it stands, and needs another plan to go on."""

    now: float


@dataclass(frozen=True, slots=True)
class PlanDue:
    """There is a better plan than the one that the robot follows; it drives on until it has that."""

    now: float


@dataclass(frozen=True, slots=True)
class GoalMoved:
    """The active goal and the poses on the way to it are elsewhere, since the map was corrected there."""

    now: float
    pose: Pose2D
    through: tuple[Pose2D, ...] = ()


@dataclass(frozen=True, slots=True)
class GoalUpdated:
    """A client has moved the active goal, while the robot drives to it, and limits its speed [m/s]."""

    now: float
    pose: Pose2D
    speed_limit: float


@dataclass(frozen=True, slots=True)
class PosesPassed:
    """The robot passed this number of the poses on its way."""

    now: float
    count: int


@dataclass(frozen=True, slots=True)
class ControlTick:
    """A control cycle begins.

    Parameters
    ----------
    pose : Pose2D, optional
        Pose of the robot in the map frame; None if it is not known well enough to move.
    reason : str
        Why the pose is not known.
    no_progress : ProgressFailure, optional
        Set if the robot should stop because its base does not follow commands.
    """

    now: float
    pose: Pose2D | None
    reason: str = ""
    no_progress: ProgressFailure | None = None


@dataclass(frozen=True, slots=True)
class VelocityComputed:
    """Answer to ``ComputeVelocity``; ``goal_reached`` means that the robot stands at its goal."""

    now: float
    velocity: Velocity
    goal_reached: bool = False


@dataclass(frozen=True, slots=True)
class ControlFailed:
    """Answer to ``ComputeVelocity``: every velocity would lead to a collision.

    ``final`` means that neither another plan nor a recovery behaviour can change that.
    """

    now: float
    reason: str = ""
    final: bool = False


@dataclass(frozen=True, slots=True)
class RecoveryStepped:
    """Answer to ``Recover``: the behaviour continues with this velocity."""

    now: float
    velocity: Velocity


@dataclass(frozen=True, slots=True)
class RecoveryEnded:
    """Answer to ``Recover``: the behaviour is done, or failed for the given reason."""

    now: float
    reason: str = ""


Event = (
    GoalReceived
    | CancelReceived
    | Preempted
    | PlanSucceeded
    | PlanFailed
    | PlanDeferred
    | PlanBlocked
    | Held
    | PlanDue
    | GoalMoved
    | GoalUpdated
    | PosesPassed
    | ControlTick
    | VelocityComputed
    | ControlFailed
    | RecoveryStepped
    | RecoveryEnded
)
