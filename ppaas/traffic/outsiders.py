"""Outsiders: robots on the map that take no part in the traffic, and the cells that they are in."""

import math
from collections.abc import Iterable, Sequence

from ppaas.costmap.moving_obstacles import MovingObstacle
from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.traffic.members import Cell, Member

FRESH = 1.0
"""Age up to which the positions of outsiders are used [s]."""

ITSELF = 0.3
"""Distance from the position that a robot of the traffic reports within which another one is that robot [m]."""


class Outsiders:
    """Cells that outsiders touch, and for how long they have."""

    def __init__(self) -> None:
        self._since: dict[Cell, float] = {}
        self._seen_at = float("-inf")

    def see(
        self, robots: Sequence[MovingObstacle], members: Iterable[Member], cells: MetricRoadmap, now: float
    ) -> None:
        """Note where all robots on the map are now; those of the traffic are left out.

        Parameters
        ----------
        robots : sequence of MovingObstacle
            With a margin around each, in the map frame.
        members : iterable of Member
            Robots of the traffic.
        cells : MetricRoadmap
        now : float
            Time [s].
        """
        known = [(member.report.x, member.report.y) for member in members]
        before, self._since, self._seen_at = self._since, {}, now
        for robot in robots:
            if all(math.hypot(robot.x - x, robot.y - y) > ITSELF for x, y in known):
                for cell in cells.touched(robot.x, robot.y, robot.radius).tolist():
                    self._since[cell] = before.get(cell, now)

    def are_in(self, cell: Cell, now: float) -> bool:
        """Return whether an outsider is in a cell."""
        return cell in self._since and now - self._seen_at <= FRESH

    def staying(self, patience: float, now: float) -> list[Cell]:
        """Return the cells in which an outsider has been for a time [s]."""
        if now - self._seen_at > FRESH:
            return []
        return [cell for cell, since in self._since.items() if now - since > patience]
