"""Store and forward: while a remote store is unreachable, its plans wait on the disk, and planning continues."""

import logging
import threading
from collections.abc import Iterable, Sequence
from typing import Any

from ppaas.errors import NotFound, PPaaSError, Unavailable
from storage.plan_checks import check_plan
from storage.ports import Store
from storage.records import PlanRecord
from storage.store_and_forward.plan_outbox import PlanOutbox

logger = logging.getLogger(__name__)

AT_ONCE = 64
"""Plans that are sent in one call."""

RETRY = 1.0
"""Time between two attempts to reach the store [s]."""


class StoreAndForward:
    """A ``Store`` in front of a remote one; plans that the remote store cannot take now wait in an outbox.

    While a plan waits, new ones are queued behind it: plans arrive in order, and no caller waits for a store that does
    not respond. Plans that were sent without an acknowledgement are sent again, which changes nothing
    (``PlanStore.add_plan``). A queued plan is found by its id only. All other calls go to the remote store, and fail
    while it is unreachable.

    Parameters
    ----------
    store : Store
        The remote store; closed with this one.
    outbox : PlanOutbox
        The queue; closed with this one.
    retry : float
        Time between two attempts to send [s].
    """

    def __init__(self, store: Store, outbox: PlanOutbox, retry: float = RETRY) -> None:
        self._store = store
        self._outbox = outbox
        self._retry = retry
        self._closing = threading.Event()
        self._something = threading.Event()
        self._something.set()  # an earlier process may have left plans
        self._sender = threading.Thread(target=self._send_all, name="outbox", daemon=True)
        self._sender.start()

    def __getattr__(self, name: str) -> Any:
        """Return an attribute of the remote store: all methods that the outbox does not affect."""
        return getattr(self._store, name)

    def close(self) -> None:
        """Close the store and the outbox; queued plans stay in the file."""
        self._closing.set()
        self._something.set()
        self._store.close()
        self._sender.join()
        self._outbox.close()

    def waiting(self) -> int:
        """Return the number of queued plans."""
        return len(self._outbox)

    def add_plan(self, record: PlanRecord) -> None:
        """Store or queue a plan; adding the same id again changes nothing."""
        self.add_plans((record,))

    def add_plans(self, records: Iterable[PlanRecord]) -> int:
        """Store or queue plans, all or none; return the number of new ones, as far as it is known."""
        checked = [check_plan(record) for record in records]
        if self._outbox.is_empty():
            try:
                return self._store.add_plans(checked)
            except Unavailable as error:
                logger.warning("plans are queued until the store is reachable: %s", error)
        new = self._outbox.put(checked)
        self._something.set()
        return new

    def plan(self, plan_id: str) -> PlanRecord:
        """Return a stored or queued plan; ``NotFound`` if it does not exist."""
        waiting = self._outbox.find(plan_id)
        return self._store.plan(plan_id) if waiting is None else waiting

    def whole_plans(self, plan_ids: Sequence[str]) -> dict[str, PlanRecord]:
        """Return the stored or queued plans among these ids, by id."""
        found = self._store.whole_plans(plan_ids)
        waiting = ((plan_id, self._outbox.find(plan_id)) for plan_id in plan_ids if plan_id not in found)
        return found | {plan_id: record for plan_id, record in waiting if record is not None}

    def remove_plan(self, plan_id: str) -> None:
        """Remove a stored or queued plan; ``NotFound`` if it does not exist."""
        with self._outbox.sending():
            try:
                self._store.remove_plan(plan_id)
            except NotFound:
                if not self._outbox.forget(plan_id):
                    raise
            else:
                self._outbox.forget(plan_id)

    def remove_plans(self, map_id: str) -> int:
        """Remove the stored and queued plans of a map; return their number."""
        with self._outbox.sending():
            return self._store.remove_plans(map_id) + self._outbox.forget_plans(map_id)

    # -- sender thread -------------------------------------------------------------------------------------------------

    def _send_all(self) -> None:
        while not self._closing.is_set():
            try:
                while not self._closing.is_set() and self._send_some():
                    continue
                self._something.clear()
                if self._outbox.is_empty() and not self._closing.is_set():
                    self._something.wait()
            except Unavailable as error:
                logger.debug("plans are still queued: %s", error)
                self._closing.wait(self._retry)
            except Exception:
                if not self._closing.is_set():
                    logger.exception("plans cannot be sent to the store")
                self._closing.wait(self._retry)

    def _send_some(self) -> bool:
        with self._outbox.sending():
            oldest = self._outbox.oldest(AT_ONCE)
            if oldest:
                self._send(list(oldest.values()))
                self._outbox.remove(list(oldest))
                logger.info("%d queued plans were sent to the store", len(oldest))
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
            else:  # dropped, because it would block the queue for ever
                logger.error("the store refused queued plan %s, which is lost: %s", records[0].id, error)
