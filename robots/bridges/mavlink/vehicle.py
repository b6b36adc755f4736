"""State of a vehicle, from its messages: where it is, what mode it is in, and what has happened to it."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

from robots.bridges.mavlink.dialect import mavlink
from robots.bridges.mavlink.modes import ARMED, ModeBook, book_of

BOOT_JUMP = 2000
"""Time by which the clock of a vehicle goes back when it has restarted [ms]; late messages are younger."""

BOOT_END = 0xFFFFFFFF - 60_000
"""Time after which the clock begins again without a restart, for it has 32 bits [ms]."""

FIX_3D = mavlink.GPS_FIX_TYPE_3D_FIX

MAX_TEXT = 200
"""Largest length of a text of a vehicle that is kept [characters]."""

_CHUNK = 50
"""Length of a part of a text [characters]; a shorter one is the last."""

BAD = mavlink.MAV_SEVERITY_WARNING
"""Least urgent severity of a text that is a warning; smaller numbers are more urgent."""


@dataclass(frozen=True, slots=True)
class ModeChanged:
    """The vehicle is in another mode."""

    before: int
    after: int


@dataclass(frozen=True, slots=True)
class ArmedChanged:
    """The vehicle was armed or disarmed."""

    armed: bool


@dataclass(frozen=True, slots=True)
class Restarted:
    """The vehicle has restarted: its mission, its modes and its local frame may be others."""


@dataclass(frozen=True, slots=True)
class Text:
    """The vehicle says something, with a severity of MAVLink."""

    severity: int
    text: str


VehicleEvent = ModeChanged | ArmedChanged | Restarted | Text


@dataclass(frozen=True, slots=True)
class GeoPosition:
    """Latitude, longitude [°], and velocities to the north and the east [m/s]."""

    latitude: float
    longitude: float
    north_speed: float
    east_speed: float


@dataclass(frozen=True, slots=True)
class LocalPosition:
    """North, east of the origin of the vehicle's frame [m], and velocities in these directions [m/s]."""

    north: float
    east: float
    north_speed: float
    east_speed: float


@dataclass(frozen=True, slots=True)
class Charge:
    """Voltage [V], current [A] and share from 0 to 1 of a battery; NaN for what is not known."""

    voltage: float
    current: float
    share: float


class Vehicle:
    """Vehicle, as its messages describe it.

    Parameters
    ----------
    system, component : int
        Numbers of its autopilot.
    autopilot : int
        Number of the make.

    Attributes
    ----------
    book : ModeBook
    heard_at : float
        Time of the last heartbeat [s].
    mode : int
        Mode by the last heartbeat; −1 before it.
    armed : bool
    fix : int
        Type of the fix of its GPS, as in MAVLink; −1 if it has sent none.
    deviation : float
        Standard deviation of its GPS [m]; NaN if it gives none.
    geo, local : GeoPosition, LocalPosition or None
        Newest positions, and the times at which they came [s].
    yaw, yaw_rate : float or None
        Heading clockwise from north [rad], and its change [rad/s].
    charge : Charge or None
    """

    def __init__(self, system: int, component: int, autopilot: int) -> None:
        self.system, self.component = system, component
        self.book: ModeBook = book_of(autopilot)
        self.heard_at = -math.inf
        self.mode, self.armed, self.fix, self.deviation = -1, False, -1, math.nan
        self.geo: GeoPosition | None = None
        self.local: LocalPosition | None = None
        self.geo_at = self.local_at = self.yaw_at = -math.inf
        self.yaw: float | None = None
        self.yaw_rate = 0.0
        self.charge: Charge | None = None
        self._boot = -1
        self._parts: dict[int, list[str]] = {}

    def take(self, message: Any, now: float) -> list[VehicleEvent]:
        """Take a message of the vehicle that arrived at a time [s]; return what has happened."""
        events = self._clock(getattr(message, "time_boot_ms", None))
        take = self._TAKERS.get(message.get_type())
        return events if take is None else [*events, *take(self, message, now)]

    @property
    def mode_name(self) -> str:
        """Name of the mode."""
        return "no mode yet" if self.mode < 0 else self.book.name_of(self.mode)

    def _clock(self, boot: int | None) -> list[VehicleEvent]:
        if boot is None:
            return []
        goes_back = boot < self._boot - BOOT_JUMP
        restarted = goes_back and self._boot < BOOT_END
        if goes_back or boot > self._boot:
            self._boot = boot
        if not restarted:
            return []
        self.geo = self.local = self.yaw = None
        self.fix = -1
        return [Restarted()]

    def _heartbeat(self, message: Any, now: float) -> list[VehicleEvent]:
        self.heard_at = now
        events: list[VehicleEvent] = []
        armed = bool(message.base_mode & ARMED)
        if self.mode >= 0 and message.custom_mode != self.mode:
            events.append(ModeChanged(self.mode, message.custom_mode))
        if self.mode >= 0 and armed != self.armed:
            events.append(ArmedChanged(armed))
        self.mode, self.armed = message.custom_mode, armed
        return events

    def _geo(self, message: Any, now: float) -> list[VehicleEvent]:
        place = GeoPosition(message.lat * 1e-7, message.lon * 1e-7, message.vx * 1e-2, message.vy * 1e-2)
        known = (message.lat, message.lon) != (0, 0) and abs(place.latitude) < 90.0 and abs(place.longitude) <= 180.0
        if known:
            self.geo, self.geo_at = place, now
        return []

    def _local(self, message: Any, now: float) -> list[VehicleEvent]:
        numbers = message.x, message.y, message.vx, message.vy
        if all(map(math.isfinite, numbers)):
            self.local, self.local_at = LocalPosition(*numbers), now
        return []

    def _attitude(self, message: Any, now: float) -> list[VehicleEvent]:
        if math.isfinite(message.yaw) and math.isfinite(message.yawspeed):
            self.yaw, self.yaw_rate, self.yaw_at = message.yaw, message.yawspeed, now
        return []

    def _odometry(self, message: Any, now: float) -> list[VehicleEvent]:
        """Take the odometry of a vehicle that sends no local position, if it is in the local frame, north first."""
        w, x, y, z = message.q
        numbers = message.x, message.y, message.vx, message.vy, w, x, y, z, message.yawspeed
        if message.frame_id != mavlink.MAV_FRAME_LOCAL_NED or not all(map(math.isfinite, numbers)):
            return []
        yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
        c, s = math.cos(yaw), math.sin(yaw)
        north, east = c * message.vx - s * message.vy, s * message.vx + c * message.vy
        if message.child_frame_id == mavlink.MAV_FRAME_LOCAL_NED:
            north, east = message.vx, message.vy
        self.local, self.local_at = LocalPosition(message.x, message.y, north, east), now
        self.yaw, self.yaw_rate, self.yaw_at = yaw, message.yawspeed, now
        return []

    def _gps(self, message: Any, now: float) -> list[VehicleEvent]:
        self.fix = message.fix_type
        self.deviation = message.h_acc * 1e-3 or math.nan
        return []

    def _battery(self, message: Any, now: float) -> list[VehicleEvent]:
        cells = [cell for cell in message.voltages if cell != 0xFFFF]
        if message.id == 0:
            self.charge = Charge(
                sum(cells) * 1e-3 if cells else math.nan, _current(message), _share(message.battery_remaining)
            )
        return []

    def _system(self, message: Any, now: float) -> list[VehicleEvent]:
        voltage = math.nan if message.voltage_battery == 0xFFFF else message.voltage_battery * 1e-3
        if self.charge is None or not math.isnan(voltage):
            self.charge = Charge(voltage, _current(message), _share(message.battery_remaining))
        return []

    def _text(self, message: Any, now: float) -> list[VehicleEvent]:
        number = getattr(message, "id", 0)
        if not number:
            return [Text(message.severity, _printable(message.text))]
        if message.chunk_seq == 0:
            self._parts = {number: []}
        parts = self._parts.get(number)
        if parts is None or message.chunk_seq != len(parts):
            return []  # a part was lost
        parts.append(message.text)
        if len(message.text) == _CHUNK and sum(map(len, parts)) < MAX_TEXT:
            return []
        self._parts.clear()
        return [Text(message.severity, _printable("".join(parts)))]

    _TAKERS: ClassVar[dict[str, "Callable[[Vehicle, Any, float], list[VehicleEvent]]"]] = {
        "HEARTBEAT": _heartbeat, "GLOBAL_POSITION_INT": _geo, "LOCAL_POSITION_NED": _local, "ATTITUDE": _attitude,
        "ODOMETRY": _odometry, "GPS_RAW_INT": _gps, "BATTERY_STATUS": _battery, "SYS_STATUS": _system,
        "STATUSTEXT": _text,
    }  # fmt: skip


def _printable(text: str) -> str:
    """Return a text without control characters, which terminals would execute, and not too long."""
    return "".join(character if character.isprintable() else "?" for character in text[:MAX_TEXT])


def _current(message: Any) -> float:
    return math.nan if message.current_battery < 0 else message.current_battery * 1e-2


def _share(percent: int) -> float:
    return percent * 1e-2 if 0 <= percent <= 100 else math.nan
