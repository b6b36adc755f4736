"""A store that may be away for a while: its plans wait on the disk, and planning goes on."""

import logging
import threading
from collections.abc import Iterable, Sequence
from typing import Any

from ppaas.errors import NotFound, PPaaSError, Unavailable
from storage.plan_checks import check_plan
from storage.ports import Store
from storage.records import PlanRecord
from storage.store_and_forward.plan_outbox import Outbox

logger = logging.getLogger(__name__)

AT_ONCE = 64
"""Plans that are sent together."""

RETRY = 1.0
"""Seconds between two tries to reach a store that is away."""


class PatientStore:
    """A ``Store`` before another: what that one cannot take now of plans waits in an outbox.

    While any plan waits, others wait behind it: plans arrive in their order, and nobody waits for a store that does not
    answer. What was sent and perhaps not received is sent again, which changes nothing (``PlanStore.add_plan``). A plan
    that waits is found by its id. All else is asked of the store, and fails while that is away.

    Parameters
    ----------
    store : Store
        Which may be away; closed with this one.
    outbox : Outbox
        Closed with this one.
    retry : float
        Seconds between two tries to send what waits.
    """

    def __init__(self, store: Store, outbox: Outbox, retry: float = RETRY) -> None:
        self._store = store
        self._outbox = outbox
        self._retry = retry
        self._closing = threading.Event()
        self._something = threading.Event()
        self._something.set()  # a process before this one may have left plans
        self._sender = threading.Thread(target=self._send_all, name="outbox", daemon=True)
        self._sender.start()

    def __getattr__(self, name: str) -> Any:
        """Return what is no matter of plans that wait: the store's own."""
        return getattr(self._store, name)

    def close(self) -> None:
        """Let go of the store and the outbox; what waits goes on to wait in the file."""
        self._closing.set()
        self._something.set()
        self._store.close()
        self._sender.join()
        self._outbox.close()

    def waiting(self) -> int:
        """Return how many plans wait."""
        return len(self._outbox)

    def add_plan(self, record: PlanRecord) -> None:
        """Keep a plan, here or there; keeping the same id twice changes nothing."""
        self.add_plans((record,))

    def add_plans(self, records: Iterable[PlanRecord]) -> int:
        """Keep plans, all or none; return how many were not there before, as far as can be told now."""
        checked = [check_plan(record) for record in records]
        if self._outbox.is_empty():
            try:
                return self._store.add_plans(checked)
            except Unavailable as error:
                logger.warning("plans wait for the store: %s", error)
        new = self._outbox.put(checked)
        self._something.set()
        return new

    def plan(self, plan_id: str) -> PlanRecord:
        """Return a plan, though it waits; ``NotFound`` if there is none."""
        waiting = self._outbox.find(plan_id)
        return self._store.plan(plan_id) if waiting is None else waiting

    def whole_plans(self, plan_ids: Sequence[str]) -> dict[str, PlanRecord]:
        """Return those of some plans that are kept or wait, by id."""
        found = self._store.whole_plans(plan_ids)
        waiting = ((plan_id, self._outbox.find(plan_id)) for plan_id in plan_ids if plan_id not in found)
        return found | {plan_id: record for plan_id, record in waiting if record is not None}

    def remove_plan(self, plan_id: str) -> None:
        """Forget a plan, though it waits; ``NotFound`` if there is none."""
        with self._outbox.sending():
            try:
                self._store.remove_plan(plan_id)
            except NotFound:
                if not self._outbox.forget(plan_id):
                    raise
            else:
                self._outbox.forget(plan_id)

    def remove_plans(self, map_id: str) -> int:
        """Forget the plans of a map, though they wait; return how many."""
        with self._outbox.sending():
            return self._store.remove_plans(map_id) + self._outbox.forget_plans(map_id)

    # -- the thread that sends -----------------------------------------------------------------------------------------

    def _send_all(self) -> None:
        while not self._closing.is_set():
            try:
                while not self._closing.is_set() and self._send_some():
                    continue
                self._something.clear()
                if self._outbox.is_empty() and not self._closing.is_set():
                    self._something.wait()
            except Unavailable as error:
                logger.debug("plans still wait: %s", error)
                self._closing.wait(self._retry)
            except Exception:
                if not self._closing.is_set():
                    logger.exception("plans cannot be sent to the store")
                self._closing.wait(self._retry)

    def _send_some(self) -> bool:
        """Send the plans that wait for longest; tell whether there were any."""
        with self._outbox.sending():
            oldest = self._outbox.oldest(AT_ONCE)
            if oldest:
                self._send(list(oldest.values()))
                self._outbox.remove(list(oldest))
                logger.info("%d plans that waited arrived at the store", len(oldest))
        return bool(oldest)

    def _send(self, records: list[PlanRecord]) -> None:
        try:
            self._store.add_plans(records)
        except Unavailable:
            raise
        except PPaaSError as error:
            if len(records) > 1:
                for record in records:
                    self._send([record])
            else:  # else it would hold up all others for ever
                logger.error("the store refuses plan %s, which is lost: %s", records[0].id, error)
