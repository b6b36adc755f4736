"""Queries for stored plans, and the exact tests that all backends share."""

from collections.abc import Iterable

import msgspec

from ppaas.plans.encoding.index_cells import Position, scope_of
from ppaas.plans.passages import check_search, joins, length_between, passage
from storage.names import check_name
from storage.plan_checks import array_of
from storage.records import PlanPassage, PlanRecord
from storage.versions import without_poses


class PlanStoreQuery(msgspec.Struct, frozen=True):
    """A query for plans between two places on a map version, of one planner or of any.

    Parameters
    ----------
    map, version : str
        Id and version of the map.
    start, goal : tuple of float
        The two places: x, y [m] in the map frame.
    tolerance : float
        Largest distance of a plan from each place [m].
    planner : str, optional
        Name of the planner; any planner by default.

    Raises
    ------
    InvalidInput
        The name of the map is not valid, a place is not finite, or the tolerance is too large.
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
        """Key of the map version in indexes (``ppaas.plans.encoding.index_cells``)."""
        return scope_of(self.map, self.version)

    def matches(self, plan: PlanRecord) -> bool:
        """Return whether a plan is on this map version, and by this planner."""
        return (plan.map, plan.version) == (self.map, self.version) and self.planner in (None, plan.planner)

    def joins(self, first: Position, last: Position) -> bool:
        """Return whether a plan from ``first`` to ``last`` connects the start with the goal, within the tolerance."""
        return joins(first, last, self.start, self.goal, self.tolerance)

    def passages(self, plans: Iterable[PlanRecord], limit: int) -> list[PlanPassage]:
        """Return the plans that pass near the start and later near the goal, shortest passage first."""
        found = []
        for plan in filter(self.matches, plans):
            points = array_of(plan.poses)[:, :2]
            ends = passage(points, self.start, self.goal, self.tolerance)
            if ends is not None:
                found.append((length_between(points, *ends), PlanPassage(without_poses(plan), *ends)))
        return [passes for _, passes in sorted(found, key=lambda each: (each[0], each[1].head.id))[:limit]]
