"""Modes of the two autopilots: their numbers and names, and the commands that set them."""

from dataclasses import dataclass
from typing import Any

from ppaas.errors import Conflict
from robots.bridges.mavlink.dialect import mavlink

CUSTOM = mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
ARMED = mavlink.MAV_MODE_FLAG_SAFETY_ARMED


@dataclass(frozen=True, slots=True)
class ModeBook:
    """Modes of an autopilot, by the number that its heartbeat has.

    Attributes
    ----------
    name : str
        Name of the autopilot.
    velocity, mission, hold : int
        Modes in which it obeys velocities, drives a mission, and stands.
    names : dict of int to str
    stream : float
        Time for which it wants setpoints before it enters the mode of velocities [s].
    first_item : int
        Number of the first item of a mission that it drives to.
    """

    name: str
    velocity: int
    mission: int
    hold: int
    names: dict[int, str]
    stream: float
    first_item: int

    def name_of(self, mode: int) -> str:
        """Return the name of a mode, or its number."""
        return self.names.get(mode, f"mode {mode}")


def _px4(main: int, sub: int = 0) -> int:
    return main << 16 | sub << 24


_PX4_MAIN = ("MANUAL", "ALTCTL", "POSCTL", "AUTO", "ACRO", "OFFBOARD", "STABILIZED", "RATTITUDE", "SIMPLE")
_PX4_AUTO = ("READY", "TAKEOFF", "LOITER", "MISSION", "RTL", "LAND", "RTGS", "FOLLOW_TARGET", "PRECLAND")
_PX4_NAMES = {_px4(main): name for main, name in enumerate(_PX4_MAIN, 1)} | {
    _px4(4, sub): f"AUTO.{name}" for sub, name in enumerate(_PX4_AUTO, 1)
}

ARDUPILOT = ModeBook(
    "ArduPilot",
    velocity=mavlink.ROVER_MODE_GUIDED,
    mission=mavlink.ROVER_MODE_AUTO,
    hold=mavlink.ROVER_MODE_HOLD,
    names={
        number: entry.name.removeprefix("ROVER_MODE_")
        for number, entry in mavlink.enums["ROVER_MODE"].items()
        if entry.name != "ROVER_MODE_ENUM_END"
    },
    stream=0.0,
    first_item=1,  # item 0 is the vehicle's home, whatever is sent
)

PX4 = ModeBook("PX4", velocity=_px4(6), mission=_px4(4, 4), hold=_px4(4, 3), names=_PX4_NAMES, stream=1.5, first_item=0)


def book_of(autopilot: int) -> ModeBook:
    """Return the modes of an autopilot by its number in the heartbeat.

    Raises
    ------
    Conflict
        It is another one than ArduPilot and PX4.
    """
    if autopilot == mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA:
        return ARDUPILOT
    if autopilot == mavlink.MAV_AUTOPILOT_PX4:
        return PX4
    entry = mavlink.enums["MAV_AUTOPILOT"].get(autopilot)
    name = entry.name.removeprefix("MAV_AUTOPILOT_") if entry is not None else str(autopilot)
    raise Conflict(f"the vehicle's autopilot is {name}: the bridge knows the modes of ArduPilot and PX4")


def set_mode(book: ModeBook, mode: int, system: int, component: int) -> Any:
    """Return the command that sets a mode."""
    parameters = (mode >> 16 & 0xFF, mode >> 24 & 0xFF) if book is PX4 else (mode, 0)
    return command(mavlink.MAV_CMD_DO_SET_MODE, (CUSTOM, *parameters), system, component)


def command(number: int, parameters: tuple[float, ...], system: int, component: int) -> Any:
    """Return a command with up to seven parameters."""
    given = (*parameters, *(0.0,) * (7 - len(parameters)))
    return mavlink.MAVLink_command_long_message(system, component, number, 0, *given)
