"""Simulated rover without I/O: takes messages of a station, drives, and returns its own messages."""

import math
from dataclasses import dataclass
from typing import Any, Literal

from robots.bridges.mavlink.dialect import mavlink
from robots.sim.mavlink.body import RoverBody
from robots.sim.mavlink.modes import ModeTable, RoverMode

Make = Literal["ardupilot", "px4"]

GUIDED_TIMEOUT, OFFBOARD_TIMEOUT, OFFBOARD_STREAM, STATION_TIMEOUT = 3.0, 1.0, 1.0, 5.0
"""Time after which ArduPilot ends a velocity and PX4 leaves OFFBOARD, time for which PX4 wants setpoints before it, and
time without a heartbeat of its station after which ArduPilot stands [s]."""

STREAM_GAP = 0.5
"""Longest time between two setpoints of a stream [s]."""

RADIUS = 0.3
"""Distance at which an item of a mission is reached [m]."""

SPOT_TURN, GAIN = 0.17, 2.5
"""Error of the heading beyond which a rover turns on the spot [rad], and turn per error [1/s]."""


@dataclass(slots=True)
class _Target:
    speed: float = 0.0
    turn: float | None = 0.0
    bearing: float = 0.0
    at: float = -math.inf


class SimulatedRover:
    """Rover of a make.

    Parameters
    ----------
    make : str
        ``ardupilot`` or ``px4``.
    body : RoverBody
    system : int

    Attributes
    ----------
    armed : bool
    mode : RoverMode
    fix : int
        Type of the fix of its GPS.
    refusal : str
        Why it refuses to be armed; empty if it does not.
    mute : bool
        Whether it sends nothing.
    sent : list
        Messages that wait to be sent.
    station : int
        Number of the station whose heartbeat the failsafe watches.
    """

    def __init__(self, make: Make, body: RoverBody, system: int = 1) -> None:
        self.make, self.body, self.system = make, body, system
        self.armed, self.fix, self.refusal, self.mute = False, 6, "", False
        self.modes = ModeTable(make)
        self.mode: RoverMode = self.modes.hold
        self.sent: list[Any] = []
        self.station = 255
        self.now = self._booted = 0.0
        self._target = _Target()
        self._stream_since = -math.inf
        self._items: list[Any] = []
        self._upload: list[Any] = []
        self._expected = 0
        self._current = 0
        self._done = False
        self._rates: dict[int, float] = {}
        self._due: dict[int, float] = {}
        self._station_at = -math.inf

    # -- what a person does --------------------------------------------------------------------------------------------

    def order(self, text: str) -> None:
        """Do what a remote control, another station or bad luck would: ``mode MANUAL``, ``arm``, ``reboot`` …"""
        word, _, rest = text.strip().partition(" ")
        match word:
            case "mode":
                self._enter(self.modes.named(rest))
            case "arm" | "disarm":
                self.armed = word == "arm"
            case "fix":
                self.fix = int(rest)
            case "refuse":
                self.refusal = rest
            case "mute" | "speak":
                self.mute = word == "mute"
            case "reboot":
                self._reboot()
            case _:
                raise ValueError(f"the rover knows no order {text!r}")

    def _reboot(self) -> None:
        self._booted, self.armed, self.mode = self.now, False, self.modes.hold
        self._items, self._upload, self._expected, self._rates = [], [], 0, {}
        self.body.restart()

    # -- messages of a station -----------------------------------------------------------------------------------------

    def take(self, message: Any) -> None:
        """Take a message."""
        if getattr(message, "target_system", self.system) != self.system:
            return
        match message.get_type():
            case "HEARTBEAT" if message.get_srcSystem() == self.station:
                self._station_at = self.now
            case "COMMAND_LONG":
                to = message.get_srcSystem(), message.get_srcComponent()
                self._say(mavlink.MAVLink_command_ack_message(message.command, self._command(message), 0, 0, *to))
            case "SET_POSITION_TARGET_LOCAL_NED":
                self._setpoint(message)
            case "MISSION_COUNT":
                self._upload, self._expected = [], message.count
                self._ask_item(message)
            case "MISSION_ITEM_INT" if self._expected:
                self._item(message)
            case "MISSION_SET_CURRENT" if message.seq < len(self._items):
                self._current, self._done = message.seq, False

    def _command(self, message: Any) -> int:
        first = int(message.param1)
        match message.command:
            case mavlink.MAV_CMD_SET_MESSAGE_INTERVAL:
                self._rates[first] = message.param2 * 1e-6
            case mavlink.MAV_CMD_DO_SET_MODE:
                return self._set_mode(self.modes.numbered(int(message.param2), int(message.param3)))
            case mavlink.MAV_CMD_COMPONENT_ARM_DISARM:
                if first and self.refusal:
                    self.text(mavlink.MAV_SEVERITY_CRITICAL, f"PreArm: {self.refusal}")
                    return int(mavlink.MAV_RESULT_FAILED)
                self.armed = bool(first)
            case _:
                return int(mavlink.MAV_RESULT_UNSUPPORTED)
        return int(mavlink.MAV_RESULT_ACCEPTED)

    def _set_mode(self, mode: RoverMode | None) -> int:
        if mode is None:
            return int(mavlink.MAV_RESULT_UNSUPPORTED)
        streams = self.now - self._target.at <= STREAM_GAP and self.now - self._stream_since >= OFFBOARD_STREAM
        if self.make == "px4" and mode == self.modes.velocity and not streams:
            return int(mavlink.MAV_RESULT_TEMPORARILY_REJECTED)
        if mode == self.modes.mission and not self._items:
            return int(mavlink.MAV_RESULT_FAILED)
        self._enter(mode)
        return int(mavlink.MAV_RESULT_ACCEPTED)

    def _enter(self, mode: RoverMode) -> None:
        if mode != self.mode:
            self.mode = mode
            self._due[mavlink.MAVLINK_MSG_ID_HEARTBEAT] = self.now

    def _setpoint(self, message: Any) -> None:
        if self.now - self._target.at > STREAM_GAP:
            self._stream_since = self.now
        if message.type_mask & 0x1C0 != 0x1C0:
            return  # accelerations are not obeyed
        turn = None if message.type_mask & mavlink.POSITION_TARGET_TYPEMASK_YAW_RATE_IGNORE else message.yaw_rate
        speed = math.hypot(message.vx, message.vy)
        if self.make == "ardupilot":
            if self.mode != self.modes.velocity:
                return
            self._target = _Target(math.copysign(speed, message.vx), turn, 0.0, self.now)
            return
        bearing = math.atan2(message.vy, message.vx)  # also of zero: then it points north
        self._target = _Target(speed, None, bearing, self.now)

    def _ask_item(self, message: Any) -> None:
        to = message.get_srcSystem(), message.get_srcComponent()
        if len(self._upload) < self._expected:
            self._say(mavlink.MAVLink_mission_request_int_message(*to, len(self._upload)))
        else:
            self._items, self._expected, self._current, self._done = self._upload, 0, 0, False
            self._say(mavlink.MAVLink_mission_ack_message(*to, mavlink.MAV_MISSION_ACCEPTED))

    def _item(self, message: Any) -> None:
        if message.seq == len(self._upload):
            self._upload.append(message)
        self._ask_item(message)

    # -- driving -------------------------------------------------------------------------------------------------------

    def step(self, seconds: float) -> None:
        """Let a time pass: drive, watch the failsafes, and say what is due."""
        self.now += seconds
        self._failsafe()
        self.body.drive(*(self._wanted() if self.armed else (0.0, 0.0)), seconds)
        self._speak()

    def _failsafe(self) -> None:
        if not self.armed:
            return
        if self.make == "px4" and self.mode == self.modes.velocity and self.now - self._target.at > OFFBOARD_TIMEOUT:
            self.text(mavlink.MAV_SEVERITY_CRITICAL, "Offboard control lost")
            self._enter(self.modes.hold)
        driven = self.mode in (self.modes.velocity, self.modes.mission)
        silent = math.isfinite(self._station_at) and self.now - self._station_at > STATION_TIMEOUT
        if self.make == "ardupilot" and driven and silent:
            self.text(mavlink.MAV_SEVERITY_WARNING, "GCS Failsafe")
            self._enter(self.modes.hold)

    def _wanted(self) -> tuple[float, float]:
        """Return speed and turn that the mode asks for."""
        if self.mode == self.modes.mission:
            return self._along_mission()
        target = self._target
        if self.mode != self.modes.velocity or self.now - target.at > GUIDED_TIMEOUT:
            return 0.0, 0.0
        if target.turn is not None:
            return target.speed, target.turn
        return self._towards(target.bearing, target.speed)

    def _towards(self, bearing: float, speed: float) -> tuple[float, float]:
        error = math.remainder(bearing - self.body.heading, math.tau)
        return (speed if abs(error) < SPOT_TURN else 0.0), GAIN * error

    def _along_mission(self) -> tuple[float, float]:
        if self.make == "ardupilot" and self._current == 0:
            self._current = 1
        if self._done or self._current >= len(self._items):
            return 0.0, 0.0
        item = self._items[self._current]
        north, east = self.body.offset_of(item.x * 1e-7, item.y * 1e-7)
        if math.hypot(north, east) < RADIUS:
            self._say(mavlink.MAVLink_mission_item_reached_message(self._current))
            self._done = self._current == len(self._items) - 1
            self._current = min(self._current + 1, len(self._items) - 1)
            if self._done and self.make == "px4":
                self._enter(self.modes.hold)
            return 0.0, 0.0
        return self._towards(math.atan2(east, north), min(self.body.top_speed, 0.2 + math.hypot(north, east)))

    # -- its messages --------------------------------------------------------------------------------------------------

    def text(self, severity: int, text: str) -> None:
        """Say something."""
        self._say(mavlink.MAVLink_statustext_message(severity, text.encode()[:50]))

    def take_sent(self) -> list[Any]:
        """Return the messages that are to be sent now."""
        sent, self.sent = self.sent, []
        return [] if self.mute else sent

    def _say(self, message: Any) -> None:
        self.sent.append(message)

    def _speak(self) -> None:
        """Say what is due: a heartbeat each second, and what a station has asked for."""
        for number, period in {mavlink.MAVLINK_MSG_ID_HEARTBEAT: 1.0, **self._rates}.items():
            if self.now >= self._due.get(number, 0.0):
                self._due[number] = self.now + period
                if (message := self._telemetry(number)) is not None:
                    self._say(message)

    def _telemetry(self, number: int) -> Any:
        """Return a message by its number; None if the rover has nothing to say by it."""
        body, boot = self.body, round(1e3 * (self.now - self._booted))
        speeds = body.speed * math.cos(body.heading), body.speed * math.sin(body.heading)
        place = [round(degrees * 1e7) for degrees in body.place()]
        flat = [round(100 * speed) for speed in speeds]
        heading = round(math.degrees(body.heading) % 360.0 * 100) % 36000
        made: dict[int, Any] = {
            mavlink.MAVLINK_MSG_ID_HEARTBEAT: self._heartbeat(),
            mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: mavlink.MAVLink_local_position_ned_message(
                boot, body.north, body.east, 0.0, *speeds, 0.0
            ),
            mavlink.MAVLINK_MSG_ID_ATTITUDE: mavlink.MAVLink_attitude_message(
                boot, 0.0, 0.0, body.heading, 0.0, 0.0, body.turn
            ),
            mavlink.MAVLINK_MSG_ID_GPS_RAW_INT: mavlink.MAVLink_gps_raw_int_message(
                0, self.fix, *place, 0, 60, 90, 0, 0, 17, 0, 20, 30, 10, 0
            ),
            mavlink.MAVLINK_MSG_ID_SYS_STATUS: mavlink.MAVLink_sys_status_message(
                0, 0, 0, 100, 12400, 250, 76, 0, 0, 0, 0, 0, 0
            ),
        }
        if self.fix >= mavlink.GPS_FIX_TYPE_3D_FIX:
            made[mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT] = mavlink.MAVLink_global_position_int_message(
                boot, *place, 0, 0, *flat, 0, heading
            )
        if self._items:
            current = mavlink.MAVLink_mission_current_message(self._current)
            made[mavlink.MAVLINK_MSG_ID_MISSION_CURRENT] = current
        return made.get(number)

    def _heartbeat(self) -> Any:
        ardupilot = self.make == "ardupilot"
        make = mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA if ardupilot else mavlink.MAV_AUTOPILOT_PX4
        base = mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED | (mavlink.MAV_MODE_FLAG_SAFETY_ARMED if self.armed else 0)
        state = mavlink.MAV_STATE_ACTIVE if self.armed else mavlink.MAV_STATE_STANDBY
        kind = mavlink.MAV_TYPE_GROUND_ROVER
        return mavlink.MAVLink_heartbeat_message(kind, make, base, self.mode.number, state, 3)
