"""Comparison of the robots of a group with the map and with each other, which decides whose reports are used."""

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from ppaas.people.coordinator import agreement
from ppaas.people.coordinator.people_table import PeopleTable
from ppaas.people.coordinator.robots.group import Robot
from ppaas.people.coordinator.visibility import View, Walls, visible_pairs

Array = NDArray[np.float64]

WITNESSES_A_CYCLE = 5
"""Robots whose views a cycle compares with the people whom others see; the next cycle takes the next ones."""
BEHIND = 1.0
"""Distance behind a wall from which a robot cannot see a person, apart from its deviation [m]."""


class RobotComparison:
    """Comparison of the robots in one cycle.

    Parameters
    ----------
    table : PeopleTable
    robots : mapping of str to Robot
        The robots that report.
    views : sequence of View
        Views of those that are trusted, numbered as in the sorted names of ``robots``.
    walls : Walls
    bodies : (M, 2) array
        Positions of the people who may hide others [m].
    radius : float
        Radius of their bodies [m].
    """

    def __init__(
        self, table: PeopleTable, robots: Mapping[str, Robot], views: Sequence[View], walls: Walls, *, bodies: Array,
        radius: float,
    ) -> None:  # fmt: skip
        self._table, self._robots, self._names = table, robots, sorted(robots)
        self._views, self._walls = views, walls
        self._bodies, self._radius = bodies, radius

    def judge(self, turn: int, seconds: float) -> None:
        """Add evidence for and against each robot, and decide which ones are trusted.

        Parameters
        ----------
        turn : int
            Number of the comparison, which decides whose views are used.
        seconds : float
            Time since the last comparison [s].
        """
        for robot in self._robots.values():
            robot.trust.forget(seconds)
        trusted = sorted({view.robot for view in self._views})
        rounds = max(1, math.ceil(len(trusted) / WITNESSES_A_CYCLE))
        witnesses = set(trusted[turn % rounds :: rounds])
        for number, name in enumerate(self._names):
            if number in witnesses or not self._robots[name].trust.trusted:
                self._compare_with_map(self._robots[name], rounds * seconds if number in witnesses else seconds)
        agreement.compare_reports(self._table, self._robots, self._denied_by(witnesses), rounds * seconds)
        reliable = {name for name in self._names if self._robots[name].trust.reliable}
        for name in self._names:
            robot = self._robots[name]
            if not robot.trust.trusted:
                agreement.compare_distrusted(self._table, robot, self._deny_torsos(robot), seconds)
            robot.trust.judge(reliable - {name})

    def _compare_with_map(self, robot: Robot, seconds: float) -> None:
        """Add evidence for and against a robot: its people in walls, or so far behind that it cannot see them."""
        robot.trust.see(seconds, walled=robot.report.outside, clear=0)
        if len(robot.world):
            pose = robot.report.pose
            clear = self._walls.free_between(np.array([pose.x, pose.y]), robot.world, BEHIND + robot.deviation)
            robot.trust.see(seconds, walled=int((~clear).sum()), clear=int(clear.sum()))

    def _denied_by(self, witnesses: set[int]) -> dict[int, list[str]]:
        """Return the witnesses that should see a person and do not, by the row of the person."""
        views = [view for view in self._views if view.robot in witnesses]
        seen = [row for row, person in enumerate(self._table.rows) if person.seen_by]
        denied_by: dict[int, list[str]] = {}
        for number, row in self._visible(views, self._table.positions, seen):
            if self._names[number] not in self._table.rows[row].seen_by:
                denied_by.setdefault(row, []).append(self._names[number])
        return denied_by

    def _deny_torsos(self, robot: Robot) -> dict[int, list[str]]:
        """Return the robots that should see each torso of one that is not trusted, by number."""
        torsos = robot.torsos()
        deny: dict[int, list[str]] = {}
        for number, torso in self._visible(self._views, torsos, range(len(torsos))):
            deny.setdefault(torso, []).append(self._names[number])
        return deny

    def _visible(self, views: Sequence[View], people: Array, wanted: Sequence[int]) -> list[tuple[int, int]]:
        if not views or not wanted:
            return []
        return visible_pairs(views, self._walls, people, wanted, self._bodies, radius=self._radius)
