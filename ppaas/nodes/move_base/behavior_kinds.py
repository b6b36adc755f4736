"""Kinds of behaviours that clients may request: their goals, recovery behaviours, feedback and results."""

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, ClassVar, NamedTuple

import msgspec

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.messages import nav2_motions
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Duration
from ppaas.nodes.nav2_actions import BACKUP, DRIVE_ON_HEADING, SPIN, WAIT, Nav2ActionTopics
from ppaas.recoveries.back_up import BackUpRecovery
from ppaas.recoveries.base import Recovery
from ppaas.recoveries.rotate import RotateParameters, RotateRecovery
from ppaas.recoveries.straight import StraightRecovery
from ppaas.recoveries.wait import WaitRecovery

FARTHEST, LONGEST_TURN, LONGEST_WAIT = 100.0, 100.0, 86_400.0
"""Largest goals of the behaviours [m, rad, s]."""

AHEAD, BRAKING = 2.0, 0.5
"""Time ahead for which the way of a straight motion must be free [s], and its deceleration before its end [m/s²]."""

SPARE = 10.0
"""Without a time allowance a behaviour may take twice its usual time and this [s]."""


class BehaviorGoal(msgspec.Struct, frozen=True):
    """Goal of a behaviour; checkpoints contain it as JSON.

    Parameters
    ----------
    id, stamp
        As of any action's goal.
    action : str
        Name of the action.
    amount : float
        Turn, to the left if positive [rad], distance [m], or time [s].
    allowance : float
        Time limit [s].
    speed : float
        Speed of a distance [m/s].
    """

    id: str
    stamp: float
    action: str
    amount: float
    allowance: float
    speed: float = 0.0


class ErrorCodes(NamedTuple):
    """``error_code`` of results, with the numbers of Nav2."""

    invalid: int
    timeout: int
    transform: int
    collision: int


class BehaviorKind(ABC):
    """A kind of behaviour."""

    topics: ClassVar[Nav2ActionTopics]
    codes: ClassVar[ErrorCodes]
    doing: ClassVar[str]
    moves: ClassVar[bool] = True

    @property
    def action(self) -> str:
        """Name of the action."""
        return self.topics.goal.name.partition("/")[0]

    @abstractmethod
    def goal(self, name: str, stamp: float, content: Any) -> BehaviorGoal:
        """Return the goal of a message's field ``goal``; raises ``InvalidInput`` if it is none."""

    @abstractmethod
    def recovery(self, goal: BehaviorGoal) -> Recovery:
        """Return the recovery behaviour that reaches a goal."""

    @abstractmethod
    def traveled(self, so_far: float, start: Pose2D, before: Pose2D, now: Pose2D) -> float:
        """Return how far the robot has come [m, rad], from its poses at the start, a cycle before, and now."""

    @abstractmethod
    def feedback(self, done: float, goal: BehaviorGoal) -> Message:
        """Return the field ``feedback`` of a message."""

    @abstractmethod
    def result(self, seconds: float, code: int, text: str) -> Message:
        """Return the field ``result`` of a message."""

    @abstractmethod
    def so_far(self, done: float, goal: BehaviorGoal) -> str:
        """Return how much was done as text, for a behaviour that ended early."""

    def rest(self, done: float, goal: BehaviorGoal) -> BehaviorGoal:
        """Return what is left of a goal."""
        left = max(abs(goal.amount) - abs(done), 0.0)
        return msgspec.structs.replace(goal, amount=math.copysign(left, goal.amount))


class Spin(BehaviorKind):
    """Turn in place.

    Parameters
    ----------
    rotate : RotateParameters
        Speeds and acceleration of turns.
    """

    topics = SPIN
    codes = ErrorCodes(700, 701, 702, 703)
    doing = "turning in place"

    def __init__(self, rotate: RotateParameters) -> None:
        self._rotate = rotate

    def goal(self, name: str, stamp: float, content: nav2_motions.SpinGoal) -> BehaviorGoal:
        """Return the goal; the turn must be finite."""
        _check_collision_checks(content.disable_collision_checks)
        turn = _checked(content.target_yaw, LONGEST_TURN, "target_yaw", "rad")
        slowest = max(self._rotate.min_in_place_rotational_vel, 0.1)
        return BehaviorGoal(name, stamp, self.action, turn, _allowance(content.time_allowance, abs(turn) / slowest))

    def recovery(self, goal: BehaviorGoal) -> Recovery:
        """Return the recovery behaviour that turns."""
        given = msgspec.structs.asdict(self._rotate)
        return RotateRecovery(**given | {"spin_dist": goal.amount, "rotation_patience": _no_limit(goal)})

    def traveled(self, so_far: float, start: Pose2D, before: Pose2D, now: Pose2D) -> float:
        """Return the angle, to the left if positive [rad]."""
        return so_far + wrap_angle(now.theta - before.theta)

    def feedback(self, done: float, goal: BehaviorGoal) -> Message:
        """Return the angle, without its side as in Nav2."""
        return nav2_motions.SpinFeedback(abs(done))

    def result(self, seconds: float, code: int, text: str) -> Message:
        """Return the elapsed time and the error."""
        return nav2_motions.SpinResult(Duration.of(seconds), code, text)

    def so_far(self, done: float, goal: BehaviorGoal) -> str:
        """Return the angle as text."""
        return f"turned by {done:.2f} of {goal.amount:.2f} rad"


class StraightMotion(BehaviorKind):
    """Motion along a line, whose goals have a distance and a speed.

    Parameters
    ----------
    top_speed : float
        Fastest speed of the robot [m/s].
    """

    def __init__(self, top_speed: float) -> None:
        self._top_speed = top_speed

    def traveled(self, so_far: float, start: Pose2D, before: Pose2D, now: Pose2D) -> float:
        """Return the distance from the start [m]."""
        return start.distance_to(now)


class BackUp(StraightMotion):
    """Straight motion backwards."""

    topics = BACKUP
    codes = ErrorCodes(713, 711, 712, 714)
    doing = "backing up"

    def goal(self, name: str, stamp: float, content: nav2_motions.BackUpGoal) -> BehaviorGoal:
        """Return the goal; as in Nav2 the robot drives backwards whatever the signs are, and not sideways."""
        _check_collision_checks(content.disable_collision_checks)
        if content.target.y != 0.0 or content.target.z != 0.0:
            raise InvalidInput("a robot backs up straight: target.y and target.z must be 0")
        distance = abs(_checked(content.target.x, FARTHEST, "target.x", "m"))
        speed = min(abs(content.speed), self._top_speed)
        if not speed > 0.0:  # nor NaN
            raise InvalidInput("speed must not be 0 m/s")
        allowance = _allowance(content.time_allowance, distance / speed)
        return BehaviorGoal(name, stamp, self.action, distance, allowance, speed)

    def recovery(self, goal: BehaviorGoal) -> Recovery:
        """Return the recovery behaviour that backs up."""
        distance = max(goal.amount, 1e-3)
        return BackUpRecovery(backup_dist=distance, backup_speed=goal.speed, time_allowance=_no_limit(goal))

    def feedback(self, done: float, goal: BehaviorGoal) -> Message:
        """Return the distance."""
        return nav2_motions.BackUpFeedback(done)

    def result(self, seconds: float, code: int, text: str) -> Message:
        """Return the elapsed time and the error."""
        return nav2_motions.BackUpResult(Duration.of(seconds), code, text)

    def so_far(self, done: float, goal: BehaviorGoal) -> str:
        """Return the distance as text."""
        return f"backed up by {done:.2f} of {goal.amount:.2f} m"


class DriveOnHeading(StraightMotion):
    """Straight motion forwards, or backwards if distance and speed are negative."""

    topics = DRIVE_ON_HEADING
    codes = ErrorCodes(724, 721, 722, 723)
    doing = "driving straight"

    def goal(self, name: str, stamp: float, content: nav2_motions.DriveOnHeadingGoal) -> BehaviorGoal:
        """Return the goal; as in Nav2, distance and speed have one sign, and the robot does not drive sideways."""
        _check_collision_checks(content.disable_collision_checks)
        if content.target.y != 0.0 or content.target.z != 0.0:
            raise InvalidInput("a robot drives straight: target.y and target.z must be 0")
        distance = _checked(content.target.x, FARTHEST, "target.x", "m")
        if not content.speed * distance > 0.0:  # nor NaN
            raise InvalidInput("target.x and speed must have the same sign, and neither may be 0")
        speed = min(abs(content.speed), self._top_speed)
        allowance = _allowance(content.time_allowance, abs(distance) / speed)
        return BehaviorGoal(name, stamp, self.action, distance, allowance, speed)

    def recovery(self, goal: BehaviorGoal) -> Recovery:
        """Return the motion that reaches the goal."""
        speed = math.copysign(goal.speed, goal.amount)
        distance = max(abs(goal.amount), 1e-3)
        return StraightRecovery(
            distance, speed, time_allowance=_no_limit(goal), simulate_ahead_time=AHEAD, braking=BRAKING
        )

    def feedback(self, done: float, goal: BehaviorGoal) -> Message:
        """Return the distance."""
        return nav2_motions.DriveOnHeadingFeedback(done)

    def result(self, seconds: float, code: int, text: str) -> Message:
        """Return the elapsed time and the error."""
        return nav2_motions.DriveOnHeadingResult(Duration.of(seconds), code, text)

    def so_far(self, done: float, goal: BehaviorGoal) -> str:
        """Return the distance as text."""
        return f"drove {done:.2f} of {abs(goal.amount):.2f} m"


class Wait(BehaviorKind):
    """Standing still for a time."""

    topics = WAIT
    codes = ErrorCodes(740, 741, 740, 740)
    doing = "waiting as requested"
    moves = False

    def goal(self, name: str, stamp: float, content: nav2_motions.WaitGoal) -> BehaviorGoal:
        """Return the goal; the time must not be negative."""
        seconds = content.time.seconds()
        if not 0.0 <= seconds <= LONGEST_WAIT:
            raise InvalidInput(f"time must be from 0 to {LONGEST_WAIT:g} s, not {seconds:g}")
        return BehaviorGoal(name, stamp, self.action, seconds, seconds + SPARE)

    def recovery(self, goal: BehaviorGoal) -> Recovery:
        """Return the recovery behaviour that waits."""
        return WaitRecovery(wait_duration=goal.amount)

    def traveled(self, so_far: float, start: Pose2D, before: Pose2D, now: Pose2D) -> float:
        """Return 0: the robot stands."""
        return 0.0

    def feedback(self, done: float, goal: BehaviorGoal) -> Message:
        """Return the time that is left."""
        return nav2_motions.WaitFeedback(Duration.of(max(goal.amount - done, 0.0)))

    def result(self, seconds: float, code: int, text: str) -> Message:
        """Return the elapsed time and the error."""
        return nav2_motions.WaitResult(Duration.of(seconds), code, text)

    def so_far(self, done: float, goal: BehaviorGoal) -> str:
        """Return the time as text."""
        return f"waited for {done:.1f} of {goal.amount:.1f} s"


def behavior_kinds(recoveries: Sequence[Recovery], top_speed: float) -> tuple[BehaviorKind, ...]:
    """Return all kinds of behaviours of a robot, which turns as its own recovery behaviour does."""
    own = [recovery.parameters for recovery in recoveries if isinstance(recovery, RotateRecovery)]
    return Spin(own[0] if own else RotateParameters()), BackUp(top_speed), DriveOnHeading(top_speed), Wait()


def _checked(value: float, most: float, name: str, unit: str) -> float:
    if not abs(value) <= most:  # nor NaN
        raise InvalidInput(f"{name} must be from {-most:g} to {most:g} {unit}, not {value:g}")
    return value


def _check_collision_checks(disabled: bool) -> None:
    if disabled:
        raise InvalidInput("collision checks cannot be disabled: leave disable_collision_checks false")


def _allowance(given: Duration, usual: float) -> float:
    """Return a time limit [s]; as in Nav2, 0 stands for none, which here is a generous one."""
    seconds = given.seconds()
    return seconds if seconds > 0.0 else 2.0 * usual + SPARE


def _no_limit(goal: BehaviorGoal) -> float:
    """Return a time limit for the recovery behaviour beyond the goal's own, which includes the time of waiting [s]."""
    return min(2.0 * goal.allowance + 1.0, 1e6)
