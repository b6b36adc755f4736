"""Sizes of the robots of the traffic: the cells of a map depend on them."""

from collections.abc import Callable, Iterable, Sequence

import numpy as np

from ppaas.errors import InvalidInput
from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.traffic.members import Member
from ppaas.traffic.settings import TrafficParameters

MakeRoadmap = Callable[[Sequence[float], TrafficParameters], MetricRoadmap]
"""Called with the radii of robots of all sizes, in ascending order [m], and the margins; returns their roadmap."""

TOO_LARGE = "the robot is too large for the aisles in which others drive"
"""Reason why goals are refused to a robot whose cells would leave others without."""

REACH = 2.0
"""Distance within which a robot is led to a cell, in distances of neighbouring cells."""

MOST_SIZES = 3
"""Largest number of sizes that are distinguished; of more, robots count as large as the next larger ones."""


def with_size(radii: Sequence[float], radius: float) -> tuple[float, ...]:
    """Return radii in ascending order together with another one, at most `MOST_SIZES` [m].

    The smallest one and the largest one are always among them.
    """
    every = sorted({*radii, radius})
    return (*every[:1], *every[1:][1 - MOST_SIZES :])


def is_same(one: MetricRoadmap, other: MetricRoadmap) -> bool:
    """Return whether two roadmaps have the same cells, moves and barred cells for all that drive on the first one."""
    if one.spacing != other.spacing or not np.array_equal(one.centres, other.centres):
        return False
    same = np.array_equal(one.roadmap.neighbours, other.roadmap.neighbours)
    return same and not other.roadmap.barred.any()


class CellsOfSizes:
    """Cells of the map, as wide as the robots that have joined need them.

    Parameters
    ----------
    make_roadmap : callable
        Returns the roadmap for robots of some radii.
    parameters : TrafficParameters

    Attributes
    ----------
    map : MetricRoadmap or None
        None before there is a robot, and while the map has no cells for those that there are.
    radii : tuple of float
        Radii that are distinguished, in ascending order [m].
    """

    def __init__(self, make_roadmap: MakeRoadmap, parameters: TrafficParameters) -> None:
        self.map: MetricRoadmap | None = None
        self.radii: tuple[float, ...] = ()
        self._make_roadmap, self._parameters = make_roadmap, parameters
        self._none = ""

    def use(self, make_roadmap: MakeRoadmap) -> None:
        """Make the cells of another version of the map."""
        self._make_roadmap, self._none = make_roadmap, ""
        if self.radii:
            try:
                self.map = make_roadmap(self.radii, self._parameters)
            except InvalidInput as error:
                self.map, self._none = None, str(error)

    def make_room(self, radius: float, members: Iterable[Member]) -> str:
        """Make cells as robots of a radius need them; return why there are none, or too few for the others, if so.

        Cells would be too few if somebody had none in reach. They are the same object as before if nothing changes for
        those who drive on them.
        """
        radii = with_size(self.radii, radius)
        if radii == self.radii:
            return self._none
        try:
            cells = self._make_roadmap(radii, self._parameters)
        except InvalidInput as error:
            return f"{TOO_LARGE}: {error}" if self.radii else str(error)
        if any(_is_near(each, self.map) and not _is_near(each, cells) for each in members):
            return TOO_LARGE
        self.radii = radii
        if self.map is None or not is_same(self.map, cells):
            self.map = cells
        return ""


def _is_near(member: Member, cells: MetricRoadmap | None) -> bool:
    """Return whether a robot can be led to a cell."""
    if cells is None or member.misfit:
        return False
    at, within = member.report, REACH * cells.spacing
    return bool(cells.nearby(at.x, at.y, within, cells.size_of(at.radius)))
