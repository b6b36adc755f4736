"""Cache of map records, so that not every path request waits for the store."""

from collections import OrderedDict

from starlette.concurrency import run_in_threadpool

from ppaas.clock import Clock, monotonic
from ppaas.errors import Unavailable
from storage.ports import MapStore
from storage.records import MapRecord

RETRY = 5.0
"""Time after which an unreachable store is queried again for the same map [s]; a query may take as long to fail."""


class MapHeadCache:
    """Heads of recently requested maps; for use on one event loop.

    Parameters
    ----------
    size : int
        Largest number of entries; the least recently used is evicted first.
    lifetime : float
        Time for which an entry is valid [s]; changes by another process are seen after this time at the latest.
    clock : callable
        Returns monotonic time [s].
    patience : float
        Time for which an entry is used while the store is unreachable [s].
    """

    def __init__(
        self,
        size: int = 4096,
        lifetime: float = 30.0,
        clock: Clock = monotonic,
        patience: float = 24 * 3600.0,
    ) -> None:
        self._size = size
        self._lifetime = lifetime
        self._patience = patience
        self._clock = clock
        self._known: OrderedDict[str, tuple[MapRecord, float, float]] = OrderedDict()
        self._invalidations = 0

    async def head(self, store: MapStore, map_id: str) -> MapRecord:
        """Return a map without its files; ``NotFound`` if it does not exist.

        While the store is unreachable, the last known head is returned, if there is one.
        """
        now = self._clock()
        head, until, _ = self._known.get(map_id, (None, now, now))
        if head is not None and now < until:
            self._known.move_to_end(map_id)
            return head
        invalidations = self._invalidations
        try:
            head = await run_in_threadpool(store.map_head, map_id)
        except Unavailable:
            head, _, last = self._known.get(map_id, (None, now, now))
            if head is None or now >= last:
                raise
            self._known[map_id] = head, now + RETRY, last
            return head
        if self._invalidations == invalidations:  # otherwise the map may have changed meanwhile
            self._known[map_id] = head, now + self._lifetime, now + self._patience
            self._known.move_to_end(map_id)
            while len(self._known) > self._size:
                self._known.popitem(last=False)
        return head

    def forget(self, map_id: str) -> None:
        """Drop a map from the cache because it was published, changed or removed."""
        self._invalidations += 1
        self._known.pop(map_id, None)
