"""Actions ``spin``, ``backup``, ``drive_on_heading`` and ``wait``: behaviours of Move Base on request."""

from collections.abc import Callable, Sequence
from typing import Any, ClassVar, cast

import msgspec

from ppaas.controllers.base import Velocity
from ppaas.errors import InvalidInput, PPaaSError
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, Status
from ppaas.messages.base.message import Message
from ppaas.navigation.action_goals import GoalList, cancels
from ppaas.navigation.events import CancelReceived
from ppaas.navigation.progress_checker import ProgressChecker
from ppaas.nodes.action_publisher import ActionPublisher
from ppaas.nodes.base import Context, Payload, Timer, Topic
from ppaas.nodes.message_checks import expect
from ppaas.nodes.move_base.behavior_kinds import BehaviorGoal, BehaviorKind, behavior_kinds
from ppaas.nodes.move_base.surroundings import Surroundings
from ppaas.nodes.nav2_actions import BACKUP, DRIVE_ON_HEADING, SPIN, WAIT
from ppaas.recoveries.base import Recovery, RecoveryRequest

# -- one run of a behaviour --------------------------------------------------------------------------------------------


class BehaviorRun:
    """Progress of a behaviour.

    Parameters
    ----------
    kind : BehaviorKind
    goal : BehaviorGoal
    now : float
        Time at which it begins here [s].
    spent : float
        Time for which it ran in another executor [s].

    Attributes
    ----------
    done : float
        How far it has come [rad, m, s].
    sent : Velocity
        Last velocity sent to the base.
    progress : ProgressChecker
        Watches whether the base follows.
    """

    def __init__(self, kind: BehaviorKind, goal: BehaviorGoal, now: float, spent: float) -> None:
        self.kind = kind
        self.goal = goal
        self.done = 0.0
        self.sent = Velocity()
        self.progress = ProgressChecker()
        self._recovery = kind.recovery(goal)
        self._here = now
        self._began = now - spent
        self._start: Pose2D | None = None
        self._last = Pose2D(0.0, 0.0)
        self._stepped = False

    def spent(self, now: float) -> float:
        """Return how long the behaviour has taken in all [s]."""
        return now - self._began

    def is_late(self, now: float) -> bool:
        """Return whether the time allowance has passed."""
        return self.spent(now) > self.goal.allowance

    def see(self, pose: Pose2D) -> None:
        """Take the pose of the robot."""
        if self._start is None:
            self._start = self._last = pose
        self.done = self.kind.traveled(self.done, self._start, self._last, pose)
        self._last = pose

    def wait(self, now: float) -> bool:
        """Take the time of a behaviour that does not move the robot; return whether it is over."""
        self.done = now - self._here
        return self.done >= self.goal.amount

    def step(self, request: RecoveryRequest) -> Velocity | None:
        """Return the velocity of this cycle, or None when the goal is reached; raises ``RecoveryFailed``."""
        if self.goal.amount == 0.0:
            return None
        if not self._stepped:
            self._recovery.start(request)
            self._stepped = True
        return self._recovery.step(request)

    def rest(self) -> BehaviorGoal:
        """Return what is left of the goal."""
        return self.kind.rest(self.done, self.goal)


# -- the actions -------------------------------------------------------------------------------------------------------

ACTIONS = (SPIN, BACKUP, DRIVE_ON_HEADING, WAIT)
"""Actions of behaviours."""


class BehaviorState(msgspec.Struct):
    """Checkpoint of the active behaviour: what is left of it, and how long it has taken in all [s]."""

    goal: BehaviorGoal
    seconds: float


class Behaviors:
    """Runs one behaviour at once, with the collision checks of recovery behaviours.

    A behaviour preempts the goal of Move Base, and is preempted by the next one. While the robot's pose is not known,
    or its base does not follow commands, the robot stands, the status says why, and the time allowance runs on.

    Parameters
    ----------
    context : Context
        Context of the node that serves the actions.
    surroundings : Surroundings
        Pose and local costmap of the robot.
    recoveries : sequence of Recovery
        The robot's own recovery behaviours, for the speeds of turns.
    top_speed : float
        Fastest speed of the robot [m/s].
    period : float
        Period of the control cycle [s].
    send : callable
        Publishes a velocity for the base.
    preempt : callable
        Called with a reason before a behaviour begins; ends the goal of Move Base, or returns why none may begin.
    check_released : callable
        Raises ``PPaaSError`` while the robot is stopped.
    """

    subscribes: ClassVar[tuple[Topic, ...]] = tuple(topic for action in ACTIONS for topic in action[:2])
    publishes: ClassVar[tuple[Topic, ...]] = tuple(topic for action in ACTIONS for topic in action[2:])

    def __init__(
        self, context: Context, surroundings: Surroundings, recoveries: Sequence[Recovery], *, top_speed: float,
        period: float, send: Callable[[Velocity], None], preempt: Callable[[str], str],
        check_released: Callable[[], None],
    ) -> None:  # fmt: skip
        self._context = context
        self._surroundings = surroundings
        self._period = period
        self._send = send
        self._preempt = preempt
        self._check_released = check_released
        self._kinds = {kind.action: kind for kind in behavior_kinds(recoveries, top_speed)}
        self._goals: dict[str, GoalList[BehaviorGoal]] = {name: GoalList() for name in self._kinds}
        self._publishers: dict[str, ActionPublisher[BehaviorGoal]] = {
            name: ActionPublisher(context, kind.topics) for name, kind in self._kinds.items()
        }
        self._run: BehaviorRun | None = None
        self._cycle: Timer | None = None
        self._counter = 0

    @property
    def active(self) -> bool:
        """True while a behaviour runs."""
        return self._run is not None

    def publish_statuses(self) -> None:
        """Publish the statuses of all goals."""
        for name, goals in self._goals.items():
            self._publishers[name].status(goals)

    # -- goals and cancels ---------------------------------------------------------------------------------------------

    def take(self, topic: str, message: Payload) -> bool:
        """Handle a message of one of the topics; return whether it is of one."""
        name, _, part = topic.rpartition("/")
        kind = self._kinds.get(name)
        if kind is not None and part == "goal":
            self._on_goal(kind, message)
        elif kind is not None:
            cancel = expect(message, GoalID)
            self.cancel(CancelReceived(self._context.elapsed(), cancel.id, cancel.stamp.seconds()), name)
        return kind is not None

    def _on_goal(self, kind: BehaviorKind, message: Payload) -> None:
        request = cast(Any, expect(message, kind.topics.goal.type))
        if self._goals[kind.action].knows(request.goal_id.id, self._context.elapsed()):
            return
        self._counter += 1
        stamp = request.goal_id.stamp.seconds() or self._context.now()
        name = request.goal_id.id or f"{kind.action}-{self._counter}-{stamp:.3f}"
        try:
            goal = kind.goal(name, stamp, request.goal)
        except InvalidInput as error:
            self._refuse(kind, BehaviorGoal(name, stamp, kind.action, 0.0, 0.0), str(error))
            return
        reason = f"Replaced by another goal: {name}"
        if refusal := self._preempt(reason):
            self._refuse(kind, goal, refusal)
            return
        self.preempt(reason)
        self._begin(kind, goal)

    def _refuse(self, kind: BehaviorKind, goal: BehaviorGoal, reason: str) -> None:
        self._goals[kind.action].refuse(goal, self._context.elapsed(), reason)
        self._publish_end(kind, goal, Status.ABORTED, reason, kind.result(0.0, kind.codes.invalid, reason))

    def preempt(self, reason: str) -> None:
        """End the behaviour, because the robot does something else."""
        if self._run is not None:
            self._halt(self._run)
            self._end(self._run, Status.PREEMPTED, reason)

    def cancel(self, event: CancelReceived, name: str = "") -> None:
        """Cancel the behaviour if the event applies to it, and it is of the action of that name, or of any."""
        run = self._run
        if run is not None and name in ("", run.kind.action) and cancels(event, run.goal):
            self.preempt("The goal was cancelled.")

    # -- the control cycle ---------------------------------------------------------------------------------------------

    def _begin(self, kind: BehaviorKind, goal: BehaviorGoal, spent: float = 0.0) -> None:
        self._goals[kind.action].accept(goal)
        run = self._run = BehaviorRun(kind, goal, self._context.elapsed(), spent)
        self._cycle = self._context.every(self._period, self._tick)
        self._say(run, kind.doing)
        self._tick()

    def _tick(self) -> None:
        run, now = self._run, self._context.elapsed()
        if run is None:
            return
        if run.kind.moves:
            self._move(run, now)
        elif run.wait(now):
            self._end(run, Status.SUCCEEDED, "")
        else:
            self._feed_back(run)

    def _move(self, run: BehaviorRun, now: float) -> None:
        around = self._surroundings
        try:
            self._check_released()
            pose = around.pose(now)
            costmap = around.look_around(pose, now)
        except PPaaSError as error:
            self._stand(run, now, str(error), run.kind.codes.transform)
            return
        run.see(pose)
        self._feed_back(run)
        stuck = run.progress.look(now, run.sent, around.frames.odometry())
        if stuck is not None:
            self._stand(run, now, stuck.reason, run.kind.codes.timeout)
            return
        self._step(run, RecoveryRequest(now, pose, costmap, around.clear, around.fits))

    def _step(self, run: BehaviorRun, request: RecoveryRequest) -> None:
        try:
            velocity = run.step(request)
        except PPaaSError as error:
            self._fail(run, str(error), run.kind.codes.collision)
            return
        if velocity is None:
            self._halt(run)
            self._end(run, Status.SUCCEEDED, "")
        elif run.is_late(request.now):
            self._fail(run, f"the time allowance of {run.goal.allowance:g} s has passed", run.kind.codes.timeout)
        else:
            self._say(run, run.kind.doing)
            run.sent = velocity
            self._send(velocity)

    def _stand(self, run: BehaviorRun, now: float, reason: str, code: int) -> None:
        """Stand still while the behaviour cannot go on, until the time allowance has passed."""
        self._halt(run)
        if run.is_late(now):
            self._fail(run, reason, code)
        else:
            self._say(run, f"waiting: {reason}")

    def _halt(self, run: BehaviorRun) -> None:
        if run.sent != Velocity():
            run.sent = Velocity()
            self._send(Velocity())

    def _feed_back(self, run: BehaviorRun) -> None:
        self._publishers[run.kind.action].feedback(run.goal, run.kind.feedback(run.done, run.goal))

    # -- ends ----------------------------------------------------------------------------------------------------------

    def _fail(self, run: BehaviorRun, reason: str, code: int) -> None:
        self._halt(run)
        self._end(run, Status.ABORTED, f"{run.kind.so_far(run.done, run.goal)}: {reason}", code)

    def _end(self, run: BehaviorRun, status: Status, text: str, code: int = 0) -> None:
        assert self._cycle is not None
        self._cycle.stop()
        self._run = None
        now = self._context.elapsed()
        self._goals[run.kind.action].end(now, status, text)
        self._publish_end(run.kind, run.goal, status, text, run.kind.result(run.spent(now), code, text if code else ""))

    def _publish_end(self, kind: BehaviorKind, goal: BehaviorGoal, status: Status, text: str, result: Message) -> None:
        publisher = self._publishers[kind.action]
        publisher.result(goal, status, text, result)
        publisher.status(self._goals[kind.action])

    def _say(self, run: BehaviorRun, text: str) -> None:
        state = self._goals[run.kind.action].active
        if state is not None and state.text != text:
            state.text = text
            self._publishers[run.kind.action].status(self._goals[run.kind.action])

    # -- checkpoints ---------------------------------------------------------------------------------------------------

    def checkpoint(self) -> BehaviorState | None:
        """Return what is left of the active behaviour; None if there is none."""
        run = self._run
        return None if run is None else BehaviorState(run.rest(), run.spent(self._context.elapsed()))

    def restore(self, state: BehaviorState | None) -> None:
        """Continue a behaviour."""
        if state is not None:
            self._begin(self._kinds[state.goal.action], state.goal, state.seconds)
