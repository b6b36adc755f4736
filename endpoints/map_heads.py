"""Maps that were looked up a moment ago, so that a request for a path does not wait for the store each time."""

from collections import OrderedDict

from starlette.concurrency import run_in_threadpool

from ppaas.clock import Clock, monotonic
from storage.ports import MapStore
from storage.records import MapRecord


class MapHeads:
    """The heads of the maps that were asked for last. For one event loop.

    Parameters
    ----------
    size : int
        Most entries; the one unused for longest goes first.
    lifetime : float
        How long one is believed [s]: so long may what another process changed be seen as it was before.
    clock : callable
        Monotonic seconds.
    """

    def __init__(self, size: int = 4096, lifetime: float = 30.0, clock: Clock = monotonic) -> None:
        self._size = size
        self._lifetime = lifetime
        self._clock = clock
        self._known: OrderedDict[str, tuple[MapRecord, float]] = OrderedDict()
        self._forgotten = 0

    async def head(self, store: MapStore, map_id: str) -> MapRecord:
        """Return a map without its files; ``NotFound`` if there is none."""
        now = self._clock()
        head, until = self._known.get(map_id, (None, now))
        if head is not None and now < until:
            self._known.move_to_end(map_id)
            return head
        forgotten = self._forgotten
        head = await run_in_threadpool(store.map_head, map_id)
        if self._forgotten == forgotten:  # else what was read may have been changed meanwhile
            self._known[map_id] = head, now + self._lifetime
            self._known.move_to_end(map_id)
            while len(self._known) > self._size:
                self._known.popitem(last=False)
        return head

    def forget(self, map_id: str) -> None:
        """Look a map up anew: it was published, changed or removed."""
        self._forgotten += 1
        self._known.pop(map_id, None)
