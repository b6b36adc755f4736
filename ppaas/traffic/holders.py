"""Holders of cells: which robots hold each cell, who may enter it, and which cells belong to a spur."""

import math
from collections import defaultdict
from collections.abc import Mapping

from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.traffic.members import Cell, Member, Spur
from ppaas.traffic.room_in_cells import Point, beside


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
        """Let a robot hold a cell."""
        self._of[cell].add(name)

    def hold_spur(self, member: Member, spur: Spur) -> None:
        """Let a robot hold the cells of a spur."""
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

    def in_the_way(self, member: Member, cell: Cell, centre: tuple[float, float], gap: float) -> str:
        """Return a robot because of which another may not enter a cell; empty if it may.

        A robot that has no cell yet may pass one that also has none, and stands, where there is room for both and a gap
        [m], or if they come no closer.
        """
        for name in sorted(self[cell] - {member.name}):
            other = self._members[name]
            if member.chain or other.chain or not _passes(member, other, centre, gap):
                return name
        return ""


def _passes(member: Member, other: Member, centre: tuple[float, float], gap: float) -> bool:
    """Return whether there is room for a robot on the straight way to the centre of a cell beside one that stands."""
    one, two = member.report, other.report
    dx, dy = centre[0] - one.x, centre[1] - one.y
    squared = dx * dx + dy * dy
    along = 0.0 if squared == 0.0 else ((two.x - one.x) * dx + (two.y - one.y) * dy) / squared
    along = min(max(along, 0.0), 1.0)
    apart = math.hypot(one.x + along * dx - two.x, one.y + along * dy - two.y)
    now = math.hypot(one.x - two.x, one.y - two.y)
    return apart >= min(one.radius + two.radius + gap, now)


def cells_of_spur(cells: MetricRoadmap, member: Member, place: Point) -> set[Cell]:
    """Return the cells that a robot touches on the straight way from the last cell of its way to a place.

    It counts as wider by half of the room that it has beside it in a cell.
    """
    radius = member.report.radius + beside(cells.spacing, member.report.radius)
    return cells.touched_along(cells.centre(member.chain[-1]), place, radius)
