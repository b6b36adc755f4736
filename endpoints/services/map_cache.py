"""Cache of map records, so that not every path request waits for the store."""

import math

from starlette.concurrency import run_in_threadpool

from ppaas.clock import Clock, monotonic
from storage.ports import MapStore
from storage.records import MapRecord
from storage.store_cache import LIFETIME, PATIENCE, SIZE, StoreCache


class MapHeadCache(StoreCache[MapRecord]):
    """Heads of recently requested maps.

    Parameters
    ----------
    size, lifetime, patience
        As of ``StoreCache``.
    clock : callable
        Returns monotonic time [s].
    """

    def __init__(
        self,
        size: int = SIZE,
        lifetime: float = LIFETIME,
        clock: Clock = monotonic,
        patience: float = PATIENCE,
    ) -> None:
        super().__init__(size, lifetime, patience)
        self._clock = clock

    async def head(self, store: MapStore, map_id: str) -> MapRecord:
        """Return a map without its files; ``NotFound`` if it does not exist.

        While the store is unreachable, the last known head is returned, if there is one.
        """

        async def load() -> tuple[MapRecord, float]:
            return await run_in_threadpool(store.map_head, map_id), math.inf

        return await self.read(map_id, self._clock(), load)
