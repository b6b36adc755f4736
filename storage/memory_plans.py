"""Plans in memory."""

import threading
from collections.abc import Iterable

from ppaas.errors import NotFound
from storage.encoding import decode, encode
from storage.names import check_name
from storage.plan_checks import check_plan, check_replacement
from storage.plan_scan import ScannedPlans
from storage.records import PlanRecord
from storage.versions import without_poses


class MemoryPlans(ScannedPlans):
    """A ``PlanStore`` of a dictionary."""

    def __init__(self) -> None:
        self._plans_lock = threading.Lock()
        self._plans: dict[str, bytes] = {}

    def add_plan(self, record: PlanRecord) -> None:
        """Keep a plan; keeping the same id twice changes nothing."""
        self.add_plans((record,))

    def add_plans(self, records: Iterable[PlanRecord]) -> int:
        """Keep plans, all or none; return how many were not there before."""
        encoded = [(record.id, encode(check_plan(record))) for record in records]
        with self._plans_lock:
            before = len(self._plans)
            for plan_id, data in encoded:
                self._plans.setdefault(plan_id, data)
            return len(self._plans) - before

    def replace_plan(self, record: PlanRecord, *, instead_of: PlanRecord) -> None:
        """Keep a plan in place of the one of the same id; ``Conflict`` if that was changed meanwhile."""
        data = encode(check_plan(record))
        with self._plans_lock:
            kept = self._plans.get(record.id)
            check_replacement(record, None if kept is None else decode(kept, PlanRecord), instead_of)
            self._plans[record.id] = data

    def plan(self, plan_id: str) -> PlanRecord:
        """Return a plan; ``NotFound`` if there is none."""
        check_name("plan", plan_id)
        with self._plans_lock:
            if plan_id not in self._plans:
                raise NotFound("plan", plan_id)
            return decode(self._plans[plan_id], PlanRecord)

    def plans(
        self, map_id: str, *, before: tuple[float, str] | None = None, limit: int | None = None
    ) -> list[PlanRecord]:
        """Return the heads of the plans of a map, newest first."""
        check_name("map", map_id)
        older = [plan for plan in self._of(map_id) if before is None or (plan.created, plan.id) < before]
        newest = sorted(older, key=lambda plan: (plan.created, plan.id), reverse=True)[:limit]
        return [without_poses(plan) for plan in newest]

    def plan_maps(self) -> list[str]:
        """Return the ids of the maps that have plans, sorted."""
        return sorted({plan.map for plan in self._of(None)})

    def remove_plan(self, plan_id: str) -> None:
        """Forget a plan; ``NotFound`` if there is none."""
        check_name("plan", plan_id)
        with self._plans_lock:
            if self._plans.pop(plan_id, None) is None:
                raise NotFound("plan", plan_id)

    def _of(self, map_id: str | None, version: str | None = None, planner: str | None = None) -> list[PlanRecord]:
        with self._plans_lock:
            plans = [decode(data, PlanRecord) for data in self._plans.values()]
        wanted = (map_id, version, planner)
        return [
            p for p in plans if all(a in (None, b) for a, b in zip(wanted, (p.map, p.version, p.planner), strict=True))
        ]
