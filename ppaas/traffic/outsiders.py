"""Outsiders: robots and people on the map that take no part in the traffic, and the cells that they are in."""

import math
from collections.abc import Iterable, Sequence
from typing import Literal

from ppaas.costmap.moving_obstacles import MovingObstacle
from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.traffic.members import Cell, Member

FRESH = 1.0
"""Age up to which the positions of outsiders are used [s]."""

ITSELF = 0.3
"""Distance from the position that a robot of the traffic reports within which another one is that robot [m]."""

Kind = Literal["a robot outside of the traffic", "a person"]
"""Kind of an outsider, in the words for robots that wait for it."""

ROBOT: Kind = "a robot outside of the traffic"
PERSON: Kind = "a person"


class Outsiders:
    """Cells that outsiders touch, and for how long they have."""

    def __init__(self) -> None:
        self._since: dict[Kind, dict[Cell, float]] = {}
        self._seen_at: dict[Kind, float] = {}

    def see(
        self, kind: Kind, seen: Sequence[MovingObstacle], members: Iterable[Member], cells: MetricRoadmap, now: float
    ) -> None:
        """Note where all robots on the map are now, of which the robots of the traffic are left out, or all people.

        Parameters
        ----------
        kind : {"a robot outside of the traffic", "a person"}
        seen : sequence of MovingObstacle
            With a margin around each, in the map frame.
        members : iterable of Member
            Robots of the traffic.
        cells : MetricRoadmap
        now : float
            Time [s].
        """
        known = [(member.report.x, member.report.y) for member in members] if kind == ROBOT else []
        before, since = self._since.get(kind, {}), dict[Cell, float]()
        for one in seen:
            if all(math.hypot(one.x - x, one.y - y) > ITSELF for x, y in known):
                for cell in cells.touched(one.x, one.y, one.radius).tolist():
                    since[cell] = before.get(cell, now)
        self._since[kind], self._seen_at[kind] = since, now

    def in_cell(self, cell: Cell, now: float) -> str:
        """Return what is in a cell; empty if no outsider is."""
        return next((kind for kind in self._fresh(now) if cell in self._since[kind]), "")

    def staying(self, patience: float, now: float) -> list[Cell]:
        """Return the cells in which an outsider has been for a time [s]."""
        found = (self._since[kind].items() for kind in self._fresh(now))
        return [cell for cells in found for cell, since in cells if now - since > patience]

    def _fresh(self, now: float) -> list[Kind]:
        return [kind for kind, seen_at in self._seen_at.items() if now - seen_at <= FRESH]
