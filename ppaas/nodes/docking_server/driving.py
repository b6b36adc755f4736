"""Drives the robot for a goal of the docking server: through Move Base to the staging pose, then by itself."""

from collections.abc import Callable
from typing import NamedTuple

from ppaas.controllers.base import Velocity
from ppaas.docking.charge import ChargeReading
from ppaas.docking.docking import Docking
from ppaas.docking.failures import DockingFailure, DockNotReached
from ppaas.docking.orders import Docked, DriveTo, Order
from ppaas.docking.undocking import Undocking
from ppaas.messages.actionlib_msgs import GoalID, Status
from ppaas.messages.base.std_msgs import Bool, Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseStamped, Twist, Vector3
from ppaas.messages.move_base_msgs import MoveBaseActionGoal, MoveBaseActionResult, MoveBaseGoal
from ppaas.messages.nav2_servers import DockError
from ppaas.navigation.events import CancelReceived
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Timer
from ppaas.nodes.docking_server.senses import DockingSenses
from ppaas.nodes.frames import MAP

BLIND = 10.0
"""Time without any odometry after which a goal fails [s]."""

PREFIX = "docking/"
"""Beginning of the ids of the goals of Move Base."""


class DockingEnd(NamedTuple):
    """End of a goal: its status, why, the code of a failure, and where the robot docked."""

    status: Status
    text: str = ""
    code: DockError = DockError.NONE
    docked: Docked | None = None


class DockingDriver:
    """Runs one state machine at a time, and executes its orders.

    Parameters
    ----------
    context : Context
        Context of the node.
    senses : DockingSenses
    period : float
        Period of the control cycle [s].
    ended : callable
        Called when the machine has ended by itself.

    Attributes
    ----------
    docking : Docking or None
        State machine of a goal to dock.
    undocking : Undocking or None
        State machine of a goal to undock.
    held : str
        Why the robot must stand; empty if it may drive.
    """

    def __init__(
        self, context: Context, senses: DockingSenses, period: float, ended: Callable[[DockingEnd], None]
    ) -> None:
        self._context, self._senses, self._period, self._ended = context, senses, period, ended
        self.docking: Docking | None = None
        self.undocking: Undocking | None = None
        self.held = ""
        self._cycle: Timer | None = None
        self._began = self._sighted = 0.0
        self._counter = self._own_cancels = 0
        self._staging = ""
        self._lift: bool | None = None

    @property
    def runs(self) -> bool:
        """Whether a machine runs."""
        return self._cycle is not None

    @property
    def seconds(self) -> float:
        """Time for which it has run, also in executors before [s]."""
        return self._context.elapsed() - self._began

    def run(self, machine: Docking | Undocking, spent: float) -> None:
        """Start a machine; no goal of Move Base may go on. ``spent`` is the time that it took in executors before."""
        now = self._context.elapsed()
        if isinstance(machine, Docking):
            self.docking = machine
        else:
            self.undocking = machine
        self._began, self._sighted, self._lift = now - spent, now, None
        self._own_cancels += 1
        self._context.publish(topics.MOVE_BASE_CANCEL.name, GoalID())
        self._cycle = self._context.every(self._period, self.step)

    def halt(self) -> None:
        """End the machine, and stand."""
        if self._cycle is None:
            return
        self._cycle.stop()
        self._cycle = None
        if self.docking is None or self.docking.drives_itself:
            self._send(Velocity())
        self.docking = self.undocking = None
        staging, self._staging = self._staging, ""
        if staging:
            self._context.publish(topics.MOVE_BASE_CANCEL.name, GoalID(id=staging))

    def step(self) -> None:
        """Do what the machine wants now."""
        now = self._context.elapsed()
        sight = self._senses.sight(now, self.held)
        if sight is None:
            if now - self._sighted > BLIND:
                self._execute(DockNotReached("the robot sends no odometry"))
            return
        self._sighted = now
        order: Order | None
        if self.docking is not None:
            order, lift = self.docking.step(sight), self.docking.lift
        elif self.undocking is not None:
            order, lift = self.undocking.step(sight), self.undocking.lift
        else:
            return
        if lift is not None and lift is not self._lift:
            self._lift = lift
            self._context.publish(topics.LIFT.name, Bool(lift))
        self._execute(order)

    def _execute(self, order: Order | None) -> None:
        match order:
            case DriveTo():
                self._drive_to(order)
            case Velocity() if self.docking is None or self.docking.drives_itself:
                self._send(order)
            case Docked():
                self._end(DockingEnd(Status.SUCCEEDED, docked=order))
            case DockingFailure():
                self._end(DockingEnd(Status.ABORTED, str(order), order.code))
            case None:
                self._end(DockingEnd(Status.SUCCEEDED))

    def _end(self, end: DockingEnd) -> None:
        self._ended(end)
        self.halt()

    def take(self, reading: ChargeReading) -> None:
        """Take a reading of the battery."""
        if self.docking is not None:
            self.docking.charge.take(reading)

    # -- Move Base -----------------------------------------------------------------------------------------------------

    def _send(self, velocity: Velocity) -> None:
        twist = Twist(Vector3(x=velocity.linear), Vector3(z=velocity.angular))
        self._context.publish(topics.CMD_VEL.name, twist)

    def _drive_to(self, order: DriveTo) -> None:
        stamp = Time.of(self._context.now())
        self._counter += 1
        self._staging = f"{PREFIX}{self._counter}-{self._context.now():.3f}"
        target = PoseStamped(Header(stamp=stamp, frame_id=MAP), Pose.of(order.pose))
        goal = MoveBaseActionGoal(MoveBaseGoal(target), GoalID(stamp, self._staging))
        self._context.publish(topics.MOVE_BASE_GOAL.name, goal)

    def take_result(self, message: MoveBaseActionResult) -> None:
        """Take the end of the way to the staging pose."""
        status, now = message.status, self._context.elapsed()
        if self.docking is None or not self._staging or status.goal_id.id != self._staging:
            return
        self._staging = ""
        if status.status == Status.SUCCEEDED:
            self.docking.staged("", now)
        elif status.status != Status.ABORTED:
            self._end(DockingEnd(Status.PREEMPTED, status.text))
        elif (failure := self.docking.staged(status.text or "no reason was given", now)) is not None:
            self._execute(failure)

    def is_stopped_by(self, cancel: CancelReceived) -> bool:
        """Return whether a cancel of Move Base's goals is meant for the robot, or for this goal, and not sent here."""
        everything = not cancel.id and cancel.stamp == 0.0
        if everything and self._own_cancels:
            self._own_cancels -= 1
            return False
        return everything or (bool(self._staging) and cancel.id == self._staging)
