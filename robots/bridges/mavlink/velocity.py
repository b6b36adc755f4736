"""Driving by velocities: the clone's ``cmd_vel`` becomes setpoints of GUIDED or OFFBOARD, ten times a second."""

import math
from typing import Any

from robots.bridges.mavlink.authority import AuthorityStep, Given, SendMessage, VehicleAuthority
from robots.bridges.mavlink.dialect import mavlink
from robots.bridges.mavlink.modes import PX4
from robots.bridges.mavlink.vehicle import Vehicle

SILENCE = 0.5
"""Age at which a velocity counts no more [s], as docs/protocol.md demands of a base."""

LINGER = 5.0
"""Time for which a vehicle that is not to move gets zero before the bridge gives it back [s]: longer than the breaks
that Move Base takes from a base that does not follow."""

AT_REST = 1e-3
"""Speed below which a vehicle is not to move [m/s, rad/s]."""

LEAD, MOST_LEAD = 0.4, 0.15
"""PX4 turns to the bearing that the rover would have after `LEAD` [s]; beyond `MOST_LEAD` [rad] it would stand."""

CREEP = 1e-3
"""Speed with which a PX4 rover that does not drive is given a bearing, since zero has none [m/s]."""

_MASK = mavlink.POSITION_TARGET_TYPEMASK_X_IGNORE | mavlink.POSITION_TARGET_TYPEMASK_Y_IGNORE
_MASK |= mavlink.POSITION_TARGET_TYPEMASK_Z_IGNORE | mavlink.POSITION_TARGET_TYPEMASK_AX_IGNORE
_MASK |= mavlink.POSITION_TARGET_TYPEMASK_AY_IGNORE | mavlink.POSITION_TARGET_TYPEMASK_AZ_IGNORE
VELOCITY_AND_RATE = _MASK | mavlink.POSITION_TARGET_TYPEMASK_VZ_IGNORE | mavlink.POSITION_TARGET_TYPEMASK_YAW_IGNORE
VELOCITY_ALONE = _MASK | mavlink.POSITION_TARGET_TYPEMASK_YAW_IGNORE | mavlink.POSITION_TARGET_TYPEMASK_YAW_RATE_IGNORE


def setpoint(vehicle: Vehicle, speed: float, turn: float, boot_ms: int) -> Any:
    """Return the setpoint for a speed forward [m/s] and a turn counter-clockwise [rad/s].

    ArduPilot takes both, in the body's frame. A PX4 rover takes the vector of its velocity to the north and the east,
    and turns to where that points: it does not drive backwards, and turns in place for a vector of nearly no length.

    Parameters
    ----------
    vehicle : Vehicle
    speed, turn : float
    boot_ms : int
        Time of this station [ms].
    """
    if vehicle.book is not PX4:
        frame, mask, numbers = mavlink.MAV_FRAME_BODY_NED, VELOCITY_AND_RATE, (speed, 0.0)
    else:
        speed, lead = max(speed, 0.0), -turn * LEAD
        if speed > AT_REST:
            lead = min(max(lead, -MOST_LEAD), MOST_LEAD)
        bearing, length = (vehicle.yaw or 0.0) + lead, max(speed, CREEP)
        numbers = length * math.cos(bearing), length * math.sin(bearing)
        frame, mask = mavlink.MAV_FRAME_LOCAL_NED, VELOCITY_ALONE
    return mavlink.MAVLink_set_position_target_local_ned_message(
        boot_ms, vehicle.system, vehicle.component, frame, mask, 0.0, 0.0, 0.0, *numbers, 0.0, 0.0, 0.0, 0.0, 0.0, -turn
    )


class VelocityDrive:
    """Takes a vehicle while the clone wants it to move, and streams velocities to it.

    After somebody else has taken the vehicle, it is left alone until the clone has come to rest and another goal, or
    nobody's goal, moves it.

    Parameters
    ----------
    authority : VehicleAuthority
    """

    def __init__(self, authority: VehicleAuthority) -> None:
        self.authority = authority
        self._speed = self._turn = 0.0
        self._came_at = self._moved_at = -math.inf
        self._goals: frozenset[str] = frozenset()
        self._refused: frozenset[str] = frozenset()
        self._rested = True
        self._stopped = False

    def goals(self, active: frozenset[str]) -> None:
        """Take the ids of the goals that are active now."""
        self._goals = active

    def stop(self, stopped: bool, now: float) -> list[AuthorityStep]:
        """Have the vehicle stand while its robot is stopped in the cloud."""
        self._stopped = stopped
        if not stopped:
            return []
        self._speed = self._turn = 0.0
        return self._last_words(now)

    def velocity(self, speed: float, turn: float, now: float) -> list[AuthorityStep]:
        """Take a velocity of the clone at a time [s]: forward [m/s], counter-clockwise [rad/s]."""
        self._speed, self._turn, self._came_at = speed, turn, now
        if not self._moves(now):
            self._rested = True
            return []
        self._moved_at = now
        may = self._rested and not self._goals & self._refused and not self._stopped
        return self._noted(self.authority.take(self.authority.vehicle.book.velocity, now)) if may else []

    def given(self, steps: list[AuthorityStep]) -> list[AuthorityStep]:
        """Take what the authority decided after an event; return it."""
        return self._noted(steps)

    def tick(self, now: float, boot_ms: int) -> list[AuthorityStep]:
        """Do what is due, ten times a second."""
        steps = self._noted(self.authority.advance(now))
        if not self._moves(now):
            self._rested = True
            if self.authority.streams and now - self._moved_at > LINGER:
                return steps + self._last_words(now)
        if self.authority.streams:
            moves = self.authority.drives and self._moves(now)
            velocity = (self._speed, self._turn) if moves else (0.0, 0.0)
            steps.append(SendMessage(setpoint(self.authority.vehicle, *velocity, boot_ms)))
        return steps

    def _moves(self, now: float) -> bool:
        return now - self._came_at <= SILENCE and max(abs(self._speed), abs(self._turn)) > AT_REST

    def _last_words(self, now: float) -> list[AuthorityStep]:
        """Send zero once more, and have the vehicle stand in its own mode for that."""
        if not self.authority.streams:
            return []
        zero = setpoint(self.authority.vehicle, 0.0, 0.0, 0)
        return [SendMessage(zero), *self._noted(self.authority.release(now))]

    def _noted(self, steps: list[AuthorityStep]) -> list[AuthorityStep]:
        if any(isinstance(step, Given) for step in steps):
            self._refused, self._rested = self._goals, False
        return steps
