"""Recent plans: a cache of the plans that a machine read last, since robots often request the same plans."""

from collections import OrderedDict
from threading import Lock

import msgspec

from storage.ports import Store
from storage.records import PlanRecord

MOST_BYTES = 16 << 20
"""Default capacity of the cache, in poses [bytes]."""


class RecentPlans:
    """Least-recently-used cache of plans in front of the store; thread-safe.

    Parameters
    ----------
    store : Store
        Store of plans.
    most_bytes : int
        Capacity, counted in the poses of the cached plans [bytes].
    """

    def __init__(self, store: Store, most_bytes: int = MOST_BYTES) -> None:
        self._store = store
        self._most = most_bytes
        self._bytes = 0
        self._plans: OrderedDict[str, PlanRecord] = OrderedDict()
        self._lock = Lock()

    def plan(self, head: PlanRecord) -> PlanRecord:
        """Return the whole plan of a head that a query returned; ``NotFound`` if it was removed since.

        A cached plan is returned only if its head is equal to the given one, since plans may be replaced.
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
