"""Chargers that fail: robots that cannot dock there, or whose charge does not rise, go to others for a while."""

import math
from collections.abc import Mapping

from ppaas.tasks.charging import ALMOST_FULL
from ppaas.tasks.orders import RobotNow
from ppaas.tasks.records import Place, Task

SHUNNED_FOR = 600.0
"""Time for which a robot does not go to a charger again that failed it [s]."""

STALLED = 1200.0
"""Time within which the charge of a robot at a charger must rise by ``RISE`` [s]."""

RISE = 0.01
"""Least rise of the charge: reports are often whole percents."""


class ChargerWatch:
    """Watches robots at chargers, and remembers which chargers failed which robots."""

    def __init__(self) -> None:
        self._failed: dict[tuple[str, Place], float] = {}
        self._risen: dict[str, tuple[str, float, float]] = {}

    def fail(self, robot: str, charger: Place, now: float) -> None:
        """Note that a charger failed a robot."""
        self._failed = {key: at for key, at in self._failed.items() if now - at < SHUNNED_FOR}
        self._failed[robot, charger] = now

    def shuns(self, robot: str, charger: Place, now: float) -> bool:
        """Return whether a robot does not go to a charger, since that failed it some time ago."""
        return now - self._failed.get((robot, charger), -math.inf) < SHUNNED_FOR

    def stalled(self, tasks: Mapping[str, Task], robots: Mapping[str, RobotNow], now: float) -> list[tuple[Task, str]]:
        """Return the trips of robots at chargers whose charge has not risen for long, with the problem.

        It is empty if the battery is almost full: an old one may never be.

        Parameters
        ----------
        tasks : mapping of str to Task
            Tasks of robots, by robot.
        robots : mapping of str to RobotNow
            Connected robots.
        now : float
            Time [s since the epoch].
        """
        seen: dict[str, tuple[str, float, float]] = {}
        for name, task in tasks.items():
            battery = robots[name].battery if name in robots else None
            if task.trip == "charge" and task.holding is not None and battery is not None:
                trip, charge, at = self._risen.get(name, ("", 0.0, now))
                risen = trip != task.id or battery.charge >= charge + RISE
                seen[name] = (task.id, battery.charge, now) if risen else (trip, charge, at)
        self._risen = seen
        stalled = {name: charge for name, (_, charge, at) in seen.items() if now - at >= STALLED}
        return [(tasks[name], _problem(name, charge)) for name, charge in stalled.items()]


def _problem(robot: str, charge: float) -> str:
    return "" if charge >= ALMOST_FULL else f"robot {robot!r} is not charged there: its battery stays at {charge:.0%}"
