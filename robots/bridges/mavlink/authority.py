"""Authority over a vehicle: the bridge takes it for a goal, gives it back afterwards, and yields to all others."""

import math
from dataclasses import dataclass
from enum import Enum
from typing import Any

from robots.bridges.mavlink.dialect import mavlink
from robots.bridges.mavlink.modes import command, set_mode
from robots.bridges.mavlink.vehicle import ArmedChanged, ModeChanged, Restarted, Vehicle, VehicleEvent

PATIENCE, TRIES = 1.0, 3
"""Time for which the answer to a command is waited for [s], and how often a command is sent."""

SETTLE = 2.5
"""Time for which the heartbeat may still have the mode before the one that was commanded [s]."""


@dataclass(frozen=True, slots=True)
class SendMessage:
    """Send a message to the vehicle."""

    message: Any


@dataclass(frozen=True, slots=True)
class Taken:
    """The vehicle is in the wanted mode, and armed."""


@dataclass(frozen=True, slots=True)
class Given:
    """The bridge does not drive the vehicle, or does so no more, and why: somebody else has it, or it refuses."""

    reason: str


AuthorityStep = SendMessage | Taken | Given


class Hold(Enum):
    """What the bridge has to do with the vehicle."""

    NONE = "none"
    STREAMING = "streaming"
    SETTING_MODE = "setting its mode"
    ARMING = "arming"
    DRIVING = "driving"
    RELEASING = "releasing"


@dataclass(slots=True)
class _Pending:
    message: Any
    sent_at: float = -math.inf
    tries: int = 0


def switched(vehicle: Vehicle, mode: int) -> str:
    """Return in words that somebody else has switched a vehicle to a mode."""
    name = vehicle.book.name_of(mode)
    return f"the vehicle was switched to {name} by its remote control, another station or its failsafe"


class VehicleAuthority:
    """Takes a vehicle, and gives it back.

    The mode is set and the vehicle armed by commands, each of which is sent again until it is answered. From then on
    any other mode, and a vehicle that is disarmed or restarts, means that somebody else drives: the bridge sends
    nothing more.

    Parameters
    ----------
    vehicle : Vehicle
    arm : bool
        Whether the bridge may arm the vehicle.
    """

    def __init__(self, vehicle: Vehicle, *, arm: bool) -> None:
        self.vehicle, self._arm = vehicle, arm
        self.hold = Hold.NONE
        self._wanted = -1
        self._stream_until = self._set_at = -math.inf
        self._pending: _Pending | None = None
        self._said = ""

    @property
    def drives(self) -> bool:
        """Whether the vehicle is the bridge's to drive now."""
        return self.hold is Hold.DRIVING

    @property
    def streams(self) -> bool:
        """Whether the vehicle wants setpoints now, if it is to obey velocities."""
        return self.hold not in (Hold.NONE, Hold.RELEASING)

    def take(self, mode: int, now: float) -> list[AuthorityStep]:
        """Take the vehicle in a mode, at a time [s]."""
        if self.hold not in (Hold.NONE, Hold.RELEASING):
            return []
        if not self.vehicle.armed and not self._arm:
            return self._give("the vehicle is not armed: arm it, or start the bridge with --arm; then send the goal")
        self._wanted, self._said = mode, ""
        stream = self.vehicle.book.stream if mode == self.vehicle.book.velocity else 0.0
        self._stream_until = now + stream
        self.hold = Hold.STREAMING
        return self.advance(now)

    def release(self, now: float) -> list[AuthorityStep]:
        """Have the vehicle stand in its mode for that, unless somebody else drives it."""
        if self.hold in (Hold.NONE, Hold.RELEASING):
            return []
        self.hold = Hold.RELEASING
        return self._command(self._mode_command(self.vehicle.book.hold), now)

    def forget(self, reason: str) -> list[AuthorityStep]:
        """Take it that the vehicle is out of reach, or drives no more, and why."""
        return [] if self.hold is Hold.NONE else self._give(reason)

    def let_go(self) -> None:
        """Take it that the vehicle stands in its own mode for that: nothing is sent."""
        self.hold, self._pending = Hold.NONE, None

    def happened(self, event: VehicleEvent, now: float) -> list[AuthorityStep]:
        """Take what has happened to the vehicle."""
        match event:
            case Restarted() if self.hold is not Hold.NONE:
                return self._give("the vehicle has restarted")
            case ArmedChanged(armed=False) if self.hold in (Hold.DRIVING, Hold.SETTING_MODE):
                return self._give("the vehicle was disarmed, by its remote control, another station or its failsafe")
            case ModeChanged(after=after) if self.streams and after != self._wanted:
                taking = self.hold in (Hold.STREAMING, Hold.SETTING_MODE)
                if not (taking and after == self.vehicle.book.hold):  # which the bridge may have set just before
                    return self._give(switched(self.vehicle, after))
        return []

    def take_ack(self, message: Any, now: float) -> list[AuthorityStep]:
        """Take a COMMAND_ACK."""
        pending = self._pending
        if pending is None or message.command != pending.message.command:
            return []
        if message.result == mavlink.MAV_RESULT_IN_PROGRESS:
            pending.sent_at = now
            return []
        self._pending = None
        if message.result == mavlink.MAV_RESULT_ACCEPTED:
            return self._accepted(now)
        name = mavlink.enums["MAV_RESULT"].get(message.result)
        words = name.name.removeprefix("MAV_RESULT_") if name is not None else f"result {message.result}"
        return self._refused(words)

    def note_text(self, text: str) -> None:
        """Note what the vehicle said, which may be the reason of a refusal."""
        self._said = text

    def advance(self, now: float) -> list[AuthorityStep]:
        """Do what is due at a time [s]."""
        pending = self._pending
        if pending is not None and now - pending.sent_at >= PATIENCE:
            if pending.tries >= TRIES:
                self._pending = None
                return self._refused("no answer")
            return self._send(pending, now)
        if self.hold is Hold.STREAMING and now >= self._stream_until:
            self.hold = Hold.SETTING_MODE  # also if it is there by its last heartbeat, which may be old
            return self._command(self._mode_command(self._wanted), now)
        if pending is None and self.hold in (Hold.SETTING_MODE, Hold.ARMING):
            return self._settle(now)
        return []

    def _settle(self, now: float) -> list[AuthorityStep]:
        """Go on if the heartbeat shows what the vehicle has accepted; give up if it does not for `SETTLE`."""
        vehicle, late = self.vehicle, now - self._set_at > SETTLE
        if self.hold is Hold.SETTING_MODE:
            if vehicle.mode == self._wanted:
                return self._arm_it(now)
            problem = f"the vehicle stays in {vehicle.mode_name} although it accepted another mode"
        elif vehicle.armed:
            return self._drive()
        else:
            problem = "the vehicle stays disarmed although it accepted to be armed"
        return self._give(problem) if late else []

    # -- parts ---------------------------------------------------------------------------------------------------------

    def _accepted(self, now: float) -> list[AuthorityStep]:
        if self.hold is Hold.RELEASING:
            self.hold = Hold.NONE
            return []
        self._set_at = now
        return self.advance(now)

    def _arm_it(self, now: float) -> list[AuthorityStep]:
        if self.vehicle.armed:
            return self._drive()
        if not self._arm:
            return self._give("the vehicle was disarmed before it could drive")
        self.hold = Hold.ARMING
        vehicle = self.vehicle
        wanted = command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, (1.0,), vehicle.system, vehicle.component)
        return self._command(wanted, now)

    def _drive(self) -> list[AuthorityStep]:
        self.hold = Hold.DRIVING
        return [Taken()]

    def _mode_command(self, mode: int) -> Any:
        return set_mode(self.vehicle.book, mode, self.vehicle.system, self.vehicle.component)

    def _command(self, message: Any, now: float) -> list[AuthorityStep]:
        self._pending = _Pending(message)
        return self._send(self._pending, now)

    def _send(self, pending: _Pending, now: float) -> list[AuthorityStep]:
        pending.message.confirmation = pending.tries
        pending.tries += 1
        pending.sent_at = now
        return [SendMessage(pending.message)]

    def _refused(self, words: str) -> list[AuthorityStep]:
        said = f" ({self._said})" if self._said else ""
        if self.hold is Hold.ARMING:
            return self._give(f"the vehicle refuses to be armed: {words}{said}")
        if self.hold in (Hold.STREAMING, Hold.SETTING_MODE):
            name = self.vehicle.book.name_of(self._wanted)
            return self._give(f"the vehicle refuses the mode {name}: {words}{said}")
        self.hold = Hold.NONE
        return [Given(f"the vehicle refuses to stand in {self.vehicle.book.name_of(self.vehicle.book.hold)}: {words}")]

    def _give(self, reason: str) -> list[AuthorityStep]:
        self.hold, self._pending = Hold.NONE, None
        return [Given(reason)]
