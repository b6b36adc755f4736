"""Maps that were looked up a moment ago, so that a request for a path does not wait for the store each time."""

from collections import OrderedDict

from starlette.concurrency import run_in_threadpool

from ppaas.clock import Clock, monotonic
from ppaas.errors import Unavailable
from storage.ports import MapStore
from storage.records import MapRecord

AWAY = 5.0
"""Seconds for which a store that is away is not asked for the same again: it may take as long to say that it is."""


class MapCache:
    """The heads of the maps that were asked for last. For one event loop.

    Parameters
    ----------
    size : int
        Most entries; the one unused for longest goes first.
    lifetime : float
        How long one is believed [s]: so long may what another process changed be seen as it was before.
    clock : callable
        Monotonic seconds.
    patience : float
        How long one is believed while the store is away [s].
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
        self._forgotten = 0

    async def head(self, store: MapStore, map_id: str) -> MapRecord:
        """Return a map without its files; ``NotFound`` if there is none. While the store is away, as it was of late."""
        now = self._clock()
        head, until, _ = self._known.get(map_id, (None, now, now))
        if head is not None and now < until:
            self._known.move_to_end(map_id)
            return head
        forgotten = self._forgotten
        try:
            head = await run_in_threadpool(store.map_head, map_id)
        except Unavailable:
            head, _, last = self._known.get(map_id, (None, now, now))
            if head is None or now >= last:
                raise
            self._known[map_id] = head, now + AWAY, last
            return head
        if self._forgotten == forgotten:  # else what was read may have been changed meanwhile
            self._known[map_id] = head, now + self._lifetime, now + self._patience
            self._known.move_to_end(map_id)
            while len(self._known) > self._size:
                self._known.popitem(last=False)
        return head

    def forget(self, map_id: str) -> None:
        """Look a map up anew: it was published, changed or removed."""
        self._forgotten += 1
        self._known.pop(map_id, None)
