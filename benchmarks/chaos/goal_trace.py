"""Trace of a goal: distance of its robot, and numbers of messages that the robot received, in each period."""

import math
from collections.abc import Callable
from typing import NamedTuple

PERIOD = 40.0
"""Time between two entries [s]."""


class Standing(NamedTuple):
    """State of a robot.

    Parameters
    ----------
    x, y : float
        Its position [m].
    lost : float
        Distance between its position and the one that its clone believes in [m].
    simulated : float
        Time of its world [s]; it lags behind if the computer is too slow.
    commands, cycles : int
        Numbers of commands, and of control cycles of its clone, since it was started.
    """

    x: float
    y: float
    lost: float
    simulated: float
    commands: int
    cycles: int

    def __str__(self) -> str:
        """Return where the robot is, and how far from where its clone believes it to be."""
        return f"at {self.x:.2f}, {self.y:.2f}, {self.lost:.2f} m lost"


class GoalTrace:
    """Entries about one goal since it was sent.

    Parameters
    ----------
    x, y : float
        Position of the goal [m].
    standing : callable
        Returns the state of the robot.
    """

    def __init__(self, x: float, y: float, standing: Callable[[], Standing]) -> None:
        self._x, self._y = x, y
        self._standing = standing
        self._last = standing()
        self._entries: list[str] = []

    def look(self, seconds: float) -> None:
        """Add an entry if one is due, ``seconds`` after the goal was sent."""
        if seconds < PERIOD * (len(self._entries) + 1):
            return
        now, last = self._standing(), self._last
        away = math.dist((now.x, now.y), (self._x, self._y))
        self._entries.append(
            f"after {seconds:.0f} s {away:.1f} m away, {now.lost:.1f} m lost, "
            f"{now.simulated - last.simulated:.0f} s simulated, "
            f"{now.commands - last.commands} commands in {now.cycles - last.cycles} cycles"
        )
        self._last = now

    def __str__(self) -> str:
        """Return the entries."""
        return "; ".join(self._entries)
