"""Modes of a rover, as pymavlink's own tables have them."""

from dataclasses import dataclass
from typing import Literal

from pymavlink import mavutil


@dataclass(frozen=True, slots=True)
class RoverMode:
    """Mode with its number in the heartbeat, and the two numbers of the command that sets it."""

    name: str
    number: int
    command: tuple[int, int]


class ModeTable:
    """Modes of a make.

    Parameters
    ----------
    make : str
        ``ardupilot`` or ``px4``.

    Attributes
    ----------
    hold, velocity, mission : RoverMode
        Modes in which it stands, obeys velocities, and drives a mission.
    """

    def __init__(self, make: Literal["ardupilot", "px4"]) -> None:
        if make == "ardupilot":
            table = {name: RoverMode(name, number, (number, 0)) for number, name in mavutil.mode_mapping_rover.items()}
            names = ("HOLD", "GUIDED", "AUTO")
        else:
            table = {
                name: RoverMode(name, main << 16 | sub << 24, (main, sub))
                for name, (_, main, sub) in mavutil.px4_map.items()
            }
            names = ("LOITER", "OFFBOARD", "MISSION")
        self._table = table
        self.hold, self.velocity, self.mission = (table[name] for name in names)

    def named(self, name: str) -> RoverMode:
        """Return a mode by its name; raises ``ValueError`` for an unknown one."""
        if name not in self._table:
            raise ValueError(f"the rover has no mode {name!r}; it has {', '.join(sorted(self._table))}")
        return self._table[name]

    def numbered(self, first: int, second: int) -> RoverMode | None:
        """Return a mode by the numbers of a command; None if there is none."""
        return next((mode for mode in self._table.values() if mode.command == (first, second)), None)
