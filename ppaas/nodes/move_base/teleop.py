"""Teleoperation in Move Base: an operator drives the robot by hand, and the local costmap still stops it."""

import logging
import math
from collections.abc import Callable
from typing import ClassVar, Protocol

from ppaas.controllers.base import Velocity, VelocityLimits
from ppaas.controllers.command_guard import CommandGuard
from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.operators.teleoperation import TeleopCommand, TeleopMode, TeleopState
from ppaas.navigation.passive_safety import PassiveSafety
from ppaas.navigation.teleoperation import HandDriver, Teleoperation, TeleopParameters
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Payload, Timer, Topic
from ppaas.nodes.message_checks import expect
from ppaas.nodes.move_base.speed_limits import SpeedLimits
from ppaas.nodes.move_base.surroundings import Surroundings

logger = logging.getLogger(__name__)

PERIOD = 0.05
"""Period of the control cycle while somebody drives [s]."""

STATE_PERIOD = 0.1
"""Longest time between two states while somebody drives [s]."""


class HandDrivenBase(Protocol):
    """Base of a robot that somebody drives by hand.

    Attributes
    ----------
    held : str
        Why the robot is stopped; empty if it is not.
    """

    held: str

    def send_by_hand(self, velocity: Velocity) -> None:
        """Publish a velocity for the base; while the robot is stopped, none but zero."""
        ...


class Teleop:
    """Drives as one operator commands, with the collision check of local planners.

    While somebody drives, the goal of Move Base waits, its behaviour ends, and it takes no others. The goal goes on if
    the driver gives the robot back, and ends if the turn ends otherwise.

    Parameters
    ----------
    context : Context
        Context of the node.
    surroundings : Surroundings
        Pose and local costmap of the robot.
    parameters : TeleopParameters
    guard : CommandGuard
        Stops the robot before obstacles.
    passive_safety : PassiveSafety
        Slows the robot down in front of approaching people.
    base : VelocityLimits
        Limits of the base.
    limits : SpeedLimits
        Speed limits by place, and of operators.
    driving : HandDrivenBase
        The base, and why it is stopped.
    make_way : callable
        Called with a reason when somebody begins to drive: Move Base waits.
    go_on : callable
        Called with that reason when nobody drives any more, and whether Move Base goes on.
    refusal : str
        Why this robot is not driven by hand; empty if it may be.
    """

    subscribes: ClassVar[tuple[Topic, ...]] = (topics.TELEOP_CMD,)
    publishes: ClassVar[tuple[Topic, ...]] = (topics.TELEOP_STATE,)

    def __init__(
        self, context: Context, surroundings: Surroundings, *, parameters: TeleopParameters, guard: CommandGuard,
        passive_safety: PassiveSafety, base: VelocityLimits, limits: SpeedLimits,
        driving: HandDrivenBase, make_way: Callable[[str], None], go_on: Callable[[str, bool], None], refusal: str,
    ) -> None:  # fmt: skip
        self._context = context
        self._surroundings = surroundings
        self._guard = guard
        self._passive_safety = passive_safety
        self._limits = limits
        self._driving = driving
        self._make_way, self._go_on = make_way, go_on
        self._refusal = refusal
        self._parameters = parameters
        self._fastest = Velocity(
            min(parameters.max_vel_x, base.max_vel_x), min(parameters.max_vel_theta, base.max_vel_theta)
        )
        self._machine = Teleoperation(parameters, self._fastest)
        self._cycle: Timer | None = None
        self._sent = Velocity()
        self._passed_at = self._moved_at = self._published_at = -math.inf
        self._mode = TeleopMode.FREE

    @property
    def holds(self) -> str:
        """Why Move Base takes no goal: somebody drives by hand. Empty if nobody does."""
        driver = self._machine.driver
        return "" if driver is None else _reason(driver)

    def take(self, topic: str, message: Payload) -> bool:
        """Handle a message of the topic; return whether it is of it.

        Raises
        ------
        InvalidInput
            The command is invalid.
        """
        if topic != topics.TELEOP_CMD.name:
            return False
        self._on_command(expect(message, TeleopCommand))
        return True

    def _on_command(self, command: TeleopCommand) -> None:
        now, before = self._context.elapsed(), self._machine.driver
        if not self._refusal:
            self._machine.take(command, now)
            self._hand_over(before)
        driver, wanted, period = self._machine.driver, self._machine.velocity(now), 1.0 / self._parameters.max_rate
        stops = self._sent != Velocity() == wanted
        starts = self._sent == Velocity() != wanted and now - self._moved_at >= period
        of_driver = driver is not None and driver.id == command.id
        if driver is not before or stops or starts or (of_driver and now - self._passed_at >= period):
            self._passed_at = now
            self._moved_at = now if wanted != Velocity() else self._moved_at
            self._drive(now)
            self._publish(now)
        elif not of_driver and now - self._published_at >= STATE_PERIOD:
            self._publish(now)

    def _hand_over(self, before: HandDriver | None) -> None:
        """Begin or end driving, if the driver is another one."""
        driver = self._machine.driver
        if driver is before:
            return
        logger.info("%s, in place of %s", self.holds or "nobody drives the robot by hand", before and before.name)
        self._stand()
        if driver is None:
            assert self._cycle is not None, "it runs while somebody drives"
            self._cycle.stop()
            self._cycle = None
            assert before is not None, "somebody drove before"
            self._go_on(_reason(before), self._machine.gave_back)
        else:
            self._make_way(self.holds)
            self._cycle = self._cycle or self._context.every(PERIOD, self._tick)

    def _tick(self) -> None:
        now, before = self._context.elapsed(), self._machine.driver
        self._machine.expire(now)
        self._hand_over(before)
        if self._machine.driver is not None:
            self._drive(now)
        if self._machine.driver is not before or now - self._published_at >= STATE_PERIOD:
            self._publish(now)

    # -- velocities ----------------------------------------------------------------------------------------------------

    def _drive(self, now: float) -> None:
        driver = self._machine.driver
        if driver is None:
            return
        wanted = self._machine.velocity(now)
        self._sent = self._safe(wanted, now)
        self._driving.send_by_hand(self._sent)
        if driver.lock:
            self._mode = TeleopMode.LOCKED
        elif self._sent == wanted:
            self._mode = TeleopMode.READY if wanted == Velocity() else TeleopMode.DRIVING
        else:
            self._mode = TeleopMode.BLOCKED if self._sent == Velocity() else TeleopMode.SLOWED

    def _stand(self) -> None:
        self._sent, self._mode = Velocity(), TeleopMode.FREE
        self._driving.send_by_hand(self._sent)

    def _safe(self, wanted: Velocity, now: float) -> Velocity:
        """Return a velocity that touches nothing; none without a pose."""
        if wanted == Velocity():
            return wanted
        if self._driving.held:
            self._machine.stop(self._driving.held)
            return Velocity()
        around = self._surroundings
        try:
            pose = around.pose(now)
            costmap = around.look_around(pose, now)
        except PPaaSError as error:
            self._machine.stop(str(error))
            return Velocity()
        allowed = self._guard.allowed(self._within_limit(wanted, pose), pose, costmap)
        return self._passive_safety.slowed(allowed, pose, around.walkers(pose, now))

    def _within_limit(self, wanted: Velocity, pose: Pose2D) -> Velocity:
        fastest = self._limits.at(pose).of(self._fastest.linear, 0.0)
        part = min(fastest / abs(wanted.linear), 1.0) if wanted.linear else 1.0
        return Velocity(part * wanted.linear, part * wanted.angular)

    # -- state ---------------------------------------------------------------------------------------------------------

    def _publish(self, now: float) -> None:
        driver = self._machine.driver
        state = TeleopState(
            Header(stamp=Time.of(self._context.now())), self._machine.next_state(now),
            mode=TeleopMode.REFUSED if self._refusal else self._mode, text=self._refusal,
            linear=self._sent.linear, angular=self._sent.angular,
            max_linear=self._fastest.linear, max_angular=self._fastest.angular,
            command_timeout=self._parameters.command_timeout, view_timeout=self._parameters.view_timeout,
        )  # fmt: skip
        if driver is not None:
            state.id, state.driver, state.command, state.text = driver.id, driver.name, driver.number, driver.lock
        self._published_at = now
        self._context.publish(topics.TELEOP_STATE.name, state)


def _reason(driver: HandDriver) -> str:
    return f"{driver.name or driver.id} drives the robot by hand"
