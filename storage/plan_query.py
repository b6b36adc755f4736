"""What plans are looked for, whatever store they are kept in."""

from collections.abc import Iterable

import msgspec

from ppaas.plans.encoding.index_cells import Position, scope_of
from ppaas.plans.passages import check_search, joins, length_between, passage
from storage.names import check_name
from storage.plan_checks import array_of
from storage.records import PlanPassage, PlanRecord
from storage.versions import without_poses


class PlanSearch(msgspec.Struct, frozen=True):
    """Plans between two places on a version of a map, of one planner or of any.

    Parameters
    ----------
    map, version : str
    start, goal : tuple of float
        The places, x, y [m].
    tolerance : float
        How far off plans may be [m].
    planner : str, optional

    Raises
    ------
    InvalidInput
        No name of a map, a place that is not finite, a tolerance that is too large.
    """

    map: str
    version: str
    start: Position
    goal: Position
    tolerance: float
    planner: str | None = None

    def __post_init__(self) -> None:
        check_name("map", self.map)
        check_search(self.start, self.goal, self.tolerance)

    @property
    def scope(self) -> bytes:
        """Of the version of the map."""
        return scope_of(self.map, self.version)

    def takes(self, plan: PlanRecord) -> bool:
        """Tell whether a plan is of this version of the map, and of this planner."""
        return (plan.map, plan.version) == (self.map, self.version) and self.planner in (None, plan.planner)

    def joins(self, first: Position, last: Position) -> bool:
        """Tell whether a plan from ``first`` to ``last`` leads from the start to the goal."""
        return joins(first, last, self.start, self.goal, self.tolerance)

    def passages(self, plans: Iterable[PlanRecord], limit: int) -> list[PlanPassage]:
        """Return where plans pass near the start and later near the goal, the shortest passage first."""
        found = []
        for plan in filter(self.takes, plans):
            points = array_of(plan.poses)[:, :2]
            ends = passage(points, self.start, self.goal, self.tolerance)
            if ends is not None:
                found.append((length_between(points, *ends), PlanPassage(without_poses(plan), *ends)))
        return [passes for _, passes in sorted(found, key=lambda each: (each[0], each[1].head.id))[:limit]]
