"""Watches a docked robot: whether it still stands at its dock, and whether its battery is still charged."""

import math

from ppaas.docking.charge import ChargeReading, ChargeVerdict, ChargeWatch
from ppaas.docking.dock import MappedDock
from ppaas.geometry import Pose2D

LEFT = 0.25
"""Distance from where it docked at which a robot is not docked any more [m]."""


DOCKED, CARRIES = "docked at ", "carries "
"""Beginnings of the report on a robot that stands at its dock as it should, and on one that carries a load."""


def is_well(report: str) -> bool:
    """Return whether a report is that all is as it should be."""
    return report.startswith((DOCKED, CARRIES))


class DockedWatch:
    """Judges the battery of a docked robot from time to time.

    Parameters
    ----------
    dock : MappedDock
    threshold : float
        Current from which the battery counts as charged [A].
    patience : float
        Time after which a battery that is not charged is reported [s].
    now : float
        Time [s].

    Attributes
    ----------
    problem : str
        Why the robot stands at the dock without charge, in words; empty while all is well.
    """

    def __init__(self, dock: MappedDock, threshold: float, patience: float, now: float) -> None:
        self.dock, self.problem = dock, ""
        self._patience, self._began = patience, now
        self._watch = ChargeWatch(threshold)
        self._well = now
        self._verdict = ChargeVerdict.SILENT

    @property
    def charges(self) -> bool:
        """Whether the battery was charged according to the newest readings."""
        return self._verdict is ChargeVerdict.CHARGING

    @property
    def report(self) -> str:
        """Where the robot stands, or the problem, in words."""
        return self.problem or f"{DOCKED}{self.dock.in_words}"

    def take(self, reading: ChargeReading) -> None:
        """Take a reading of the battery."""
        self._watch.take(reading)

    def look(self, now: float) -> bool:
        """Judge the newest readings; return whether the problem has changed."""
        if not self.dock.charges:
            return False
        begin = max(self._began, now - self._patience)
        verdict = self._verdict = self._watch.verdict(begin)
        if verdict is ChargeVerdict.CHARGING:
            self._well = self._watch.since(begin)[-1].at
        waited = now - self._well
        before, self.problem = self.problem, ""
        if waited > self._patience:
            self.problem = (
                f"the robot stands at {self.dock.in_words} without charge for {waited:.0f} s: {verdict.value}"
            )
        return bool(before) != bool(self.problem)


def has_left(docked: Pose2D, odometry: Pose2D) -> bool:
    """Return whether a robot that docked at a pose is not there any more; both in the odometry frame."""
    return math.dist(docked[:2], odometry[:2]) > LEFT
