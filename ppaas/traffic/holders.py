"""Holders of cells: which robots hold each, who may enter it, and which cells belong to a spur or beside a line."""

from collections import defaultdict
from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.messages.fleet.traffic import MapPoint
from ppaas.polygons import distances_between, distances_to_edges
from ppaas.traffic.members import Cell, Member, Spur
from ppaas.traffic.room_in_cells import Line, beside


def line_of(member: Member, cells: MetricRoadmap) -> Line | None:
    """Return the straight way on which a robot may be outside of its cells; None if it drives from cell to cell.

    That is its spur, its way to its first cell, or the place where it stands without a way.
    """
    if member.spur is not None:
        return member.spur.line
    if member.standing == "out" or member.report.free or (member.chain and member.reached):
        return None
    here = member.report.x, member.report.y
    return here, cells.centre(member.chain[0]) if member.chain else here


class OtherLines:
    """Straight ways of other robots.

    Parameters
    ----------
    member : Member
        The robot; its own way is left out.
    others : iterable of Member
    cells : MetricRoadmap
    """

    def __init__(self, member: Member, others: Iterable[Member], cells: MetricRoadmap) -> None:
        found = [(each, line) for each in others if each is not member and (line := line_of(each, cells)) is not None]
        self._names = [each.name for each, _ in found]
        self._ends: NDArray[np.float64] = np.array([line for _, line in found]).reshape(-1, 2, 2)
        self._radii = np.array([each.report.radius for each, _ in found]) + member.report.radius

    def near(self, line: Line, gap: float) -> set[str]:
        """Return the robots that come nearer to a line than both radii and a gap [m], and nearer than to its begin."""
        if not self._names:
            return set()
        begin, end = np.array(line)
        apart = distances_between(begin, end, self._ends[:, 0], self._ends[:, 1])
        now = distances_to_edges(self._ends[:, 0], self._ends[:, 1], begin)
        near = apart < np.minimum(self._radii + gap, now)
        return {name for name, is_near in zip(self._names, near.tolist(), strict=True) if is_near}


class Holders:
    """The robots that hold each cell.

    A cell that a robot was granted has one holder. Robots that begin where they stand may touch one cell together.

    Parameters
    ----------
    members : mapping of str to Member
        All robots, by name.
    """

    def __init__(self, members: Mapping[str, Member]) -> None:
        self._members = members
        self._of: defaultdict[Cell, set[str]] = defaultdict(set)

    def __getitem__(self, cell: Cell) -> set[str]:
        """Return the robots that hold a cell."""
        return self._of.get(cell, set())

    def hold(self, name: str, cell: Cell) -> None:
        """Mark a cell as held by a robot."""
        self._of[cell].add(name)

    def hold_spur(self, member: Member, spur: Spur) -> None:
        """Mark the cells of a spur as held by a robot."""
        member.spur = spur
        for cell in spur.cells:
            self.hold(member.name, cell)

    def let_spur_go(self, member: Member) -> None:
        """Free the cells of a robot's spur, if it has one."""
        spur, member.spur = member.spur, None
        for cell in () if spur is None else spur.cells:
            self.let_go(member.name, cell)

    def let_go(self, name: str, cell: Cell) -> None:
        """Free a cell of a robot, unless it holds it still: a way may lead through a cell twice."""
        if cell not in self._members[name].held:
            self._of[cell].discard(name)
            if not self._of[cell]:
                del self._of[cell]

    def let_all_go(self, name: str) -> None:
        """Free all cells of a robot."""
        for cell in [cell for cell, names in self._of.items() if name in names]:
            self._of[cell].discard(name)
            if not self._of[cell]:
                del self._of[cell]

    def in_the_way(self, member: Member, cell: Cell, cells: MetricRoadmap, gap: float) -> str:
        """Return a robot because of which another may not enter a cell; empty if it may.

        A robot that has no cell yet may pass others beside their cells where there is room for both and a gap [m], or
        if they come no closer.
        """
        others = self[cell] - {member.name}
        if not member.chain:
            way = (member.report.x, member.report.y), cells.centre(cell)
            others = {name for name in others if self._members[name].chain}
            others |= OtherLines(member, self._members.values(), cells).near(way, gap)
        return min(others, default="")


def spur_to(cells: MetricRoadmap, member: Member, goal: MapPoint, goal_id: str) -> Spur:
    """Return the straight way from the last cell of a robot's way to a goal, with all cells that it touches on it.

    The robot counts as wider by half of the room that it has beside it in a cell.
    """
    radius = member.report.radius + beside(cells.spacing, member.report.radius)
    line = cells.centre(member.chain[-1]), (goal.x, goal.y)
    return Spur(goal, goal_id, frozenset(cells.touched_along(*line, radius)), line)
