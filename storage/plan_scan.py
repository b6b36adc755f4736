"""Searches that look at all plans of a map, for stores that have no index of them yet."""

from abc import abstractmethod

import numpy as np
from numpy.typing import NDArray

from ppaas.plans.passages import Place, check_search, joins, length_between, passage
from storage.encoding import encode
from storage.names import check_name
from storage.records import PlanPart, PlanPassage, PlanRecord, PlanStatistics
from storage.versions import without_poses


class ScannedPlans:
    """What a ``PlanStore`` finds by looking at all plans."""

    @abstractmethod
    def _of(self, map_id: str | None, version: str | None = None, planner: str | None = None) -> list[PlanRecord]:
        """Return the plans of a map, or all."""

    @abstractmethod
    def plan(self, plan_id: str) -> PlanRecord:
        """Return a plan; ``NotFound`` if there is none."""

    def find_plans(
        self,
        map_id: str,
        version: str,
        start: Place,
        goal: Place,
        tolerance: float,
        *,
        planner: str | None = None,
        limit: int = 16,
    ) -> list[PlanRecord]:
        """Return the heads of plans whose ends lie near two places, shortest first."""
        check_name("map", map_id)
        check_search(start, goal, tolerance)
        found = []
        for record in self._of(map_id, version, planner):
            points = _points(record)
            if joins(tuple(points[0].tolist()), tuple(points[-1].tolist()), start, goal, tolerance):
                found.append(without_poses(record))
        return sorted(found, key=lambda plan: (plan.length, plan.id))[:limit]

    def plans_through(
        self,
        map_id: str,
        version: str,
        start: Place,
        goal: Place,
        tolerance: float,
        *,
        planner: str | None = None,
        limit: int = 8,
    ) -> list[PlanPassage]:
        """Return plans that pass near one place and later near another, the shortest passage first."""
        check_name("map", map_id)
        check_search(start, goal, tolerance)
        found = []
        for record in self._of(map_id, version, planner):
            points = _points(record)
            ends = passage(points, start, goal, tolerance)
            if ends is not None:
                found.append((length_between(points, *ends), record.id, PlanPassage(without_poses(record), *ends)))
        return [passes for _, _, passes in sorted(found, key=lambda each: each[:2])[:limit]]

    def plan_parts(self, plan_id: str) -> list[PlanPart]:
        """Return the stretches of a plan that are entries of their own: here none is."""
        self.plan(plan_id)
        return []

    def plan_statistics(self, map_id: str | None = None) -> PlanStatistics:
        """Return what the plans of a map take, or all."""
        plans = self._of(map_id)
        waypoints = sum(len(plan.poses) // 56 for plan in plans)
        return PlanStatistics(len(plans), waypoints, waypoints, 0, sum(len(encode(plan)) for plan in plans))


def _points(record: PlanRecord) -> NDArray[np.float64]:
    return np.frombuffer(record.poses, "<f8").reshape(-1, 7)[:, :2]
