"""Grants as messages: how many cells ahead a robot needs, and when they are sent."""

import math
from collections import Counter
from collections.abc import Container, Iterable

from msgspec.structs import replace

from ppaas.messages.base.std_msgs import Time
from ppaas.messages.fleet.traffic import TrafficGrants, TrafficReport
from ppaas.traffic.members import Arrival, Cell, Member

ROUND_TRIP = 0.5
"""Time from a report to the grants that answer it [s], over a slow network."""

REPEAT = 0.5
"""Time after which grants that have not changed are sent again, since messages may be lost [s]."""

MOST_AHEAD = 8
"""Largest number of cells that a robot is granted ahead."""


def window_of(report: TrafficReport, spacing: float) -> int:
    """Return how many cells to grant ahead, so that the robot never brakes while it waits for the next grant."""
    needed = report.braking + ROUND_TRIP * report.speed
    return min(1 + math.ceil(needed / spacing), MOST_AHEAD)


def cells_together(member: Member, no_stop: Container[Cell]) -> list[Cell]:
    """Return the next cells of a robot that are granted together: up to the first one in which it may stop.

    One cell, if it is in a zone already in which it does not stop. No cells if the plan does not lead out of one yet.
    """
    is_inside = bool(member.chain) and member.chain[-1] in no_stop
    cells: list[Cell] = []
    for cell in member.queue:
        if isinstance(cell, Arrival):
            return []
        if cell in cells:  # it goes round in the zone, and others pass meanwhile
            return cells
        cells.append(cell)
        if is_inside or cell not in no_stop:
            return cells
    return []


class GrantWriter:
    """Sends grants when they change, and again now and then."""

    def __init__(self) -> None:
        self._sent: dict[str, tuple[float, TrafficGrants]] = {}
        # Numbers of robots that were forgotten stay: a robot that comes back ignores numbers that it knows.
        self._numbers: Counter[str] = Counter()

    def next_number(self, robot: str) -> int:
        """Return the number that the next grants of a robot will have."""
        return self._numbers[robot] + 1

    def due(self, messages: Iterable[TrafficGrants], now: float) -> list[TrafficGrants]:
        """Return the messages that are to be sent now, with their numbers and times.

        Parameters
        ----------
        messages : iterable of TrafficGrants
            The grants of all robots, without numbers.
        now : float
            Time [s].
        """
        due, sent = [], {}
        for grants in messages:
            last = self._sent.get(grants.robot)
            if last is None or now - last[0] >= REPEAT or not _equal(last[1], grants):
                self._numbers[grants.robot] += 1
                header = replace(grants.header, stamp=Time.of(now))
                due.append(replace(grants, number=self._numbers[grants.robot], header=header))
                last = now, grants
            sent[grants.robot] = last
        self._sent = sent
        return due


def _equal(one: TrafficGrants, other: TrafficGrants) -> bool:
    """Return whether grants without numbers say the same, whatever their times."""
    return replace(one, header=other.header) == other
