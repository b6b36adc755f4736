"""The plans that a machine gave out last, as they were read: what one robot asks for, another often asks for soon."""

from collections import OrderedDict
from threading import Lock

import msgspec

from storage.ports import Store
from storage.records import PlanRecord

MOST_BYTES = 16 << 20
"""Of poses that are kept in memory."""


class RecentPlans:
    """Reads plans, and remembers them; several threads may use it.

    Parameters
    ----------
    store : Store
        Where plans are kept.
    most_bytes : int
        Of poses that are remembered; those asked for least lately go first.
    """

    def __init__(self, store: Store, most_bytes: int = MOST_BYTES) -> None:
        self._store = store
        self._most = most_bytes
        self._bytes = 0
        self._plans: OrderedDict[str, PlanRecord] = OrderedDict()
        self._lock = Lock()

    def plan(self, head: PlanRecord) -> PlanRecord:
        """Return the plan of a head that was just found; ``NotFound`` if it was removed since.

        One that is remembered is taken only if its head is still the same: plans may be replaced.
        """
        with self._lock:
            known = self._plans.get(head.id)
            if known is not None and msgspec.structs.replace(known, poses=b"") == head:
                self._plans.move_to_end(head.id)
                return known
        plan = self._store.plan(head.id)
        with self._lock:
            self._remember(plan)
        return plan

    def _remember(self, plan: PlanRecord) -> None:
        before = self._plans.pop(plan.id, None)
        self._bytes += len(plan.poses) - (len(before.poses) if before is not None else 0)
        self._plans[plan.id] = plan
        while self._bytes > self._most:
            _, dropped = self._plans.popitem(last=False)
            self._bytes -= len(dropped.poses)
