"""Lines beside cells: straight ways of robots that may be where they hold no cell."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.polygons import distances_between, distances_to_edges
from ppaas.traffic.members import Member
from ppaas.traffic.room_in_cells import Line


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
