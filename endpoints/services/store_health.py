"""Health check of the stores."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass

from ppaas.clock import Clock, monotonic
from ppaas.errors import PPaaSError
from storage.disk_space.reserve import DiskReserve, SpaceState
from storage.ports import MapStore, Store
from storage.store_and_forward.store import StoreAndForward

LIFETIME = 2.0
"""Time for which a result is cached [s], so that many requests do not burden a slow store."""

PATIENCE = 3.0
"""Time after which a store that does not answer counts as unreachable [s]."""


@dataclass(frozen=True, slots=True)
class StoreState:
    """State of a store: whether it answers, the reason if not, and the number of plans that wait for it here."""

    answers: bool
    reason: str | None = None
    waiting: int = 0


@dataclass(frozen=True, slots=True)
class DiskState:
    """State of the disk of the data folder, and its free space and size [bytes]."""

    state: SpaceState
    free: int
    total: int

    @property
    def reason(self) -> str | None:
        """Description of the shortage, with advice for an administrator; None if there is enough space."""
        if self.state == "ok":
            return None
        left = f"{self.free >> 20} MiB of {self.total >> 20} MiB are left"
        if self.state == "low":
            return f"the disk of the data folder is nearly full, {left}: free space"
        return f"the disk of the data folder is full, {left}, and nothing new is stored: remove maps, plans or users"


def disk_state(reserve: DiskReserve) -> DiskState | None:
    """Return the state of a disk, or None if it cannot be measured; blocks."""
    try:
        space = reserve.space()
        return DiskState(reserve.state(), space.free, space.total)
    except OSError:
        return None


class StoreHealthCheck:
    """Checks the stores of a cloud; for use on one event loop.

    Parameters
    ----------
    clock : callable
        Returns monotonic time [s].
    patience : float
        Time limit of a query [s].
    """

    def __init__(self, clock: Clock = monotonic, patience: float = PATIENCE) -> None:
        self._clock = clock
        self._patience = patience
        self._lock = asyncio.Lock()
        self._known: tuple[StoreState, StoreState] | None = None
        self._until = float("-inf")
        self._have_answered = False, False

    @property
    def have_answered(self) -> bool:
        """True once both stores have answered."""
        return all(self._have_answered)

    async def stores(self, store: Store, map_store: MapStore) -> tuple[StoreState, StoreState]:
        """Return the states of the main store and of the map store."""
        async with self._lock:
            if self._known is None or self._clock() >= self._until:
                states = await asyncio.gather(
                    self._check(lambda: store.users(limit=1), store), self._check(lambda: map_store.maps(limit=1))
                )
                self._known, self._until = (states[0], states[1]), self._clock() + LIFETIME
                once, map_once = self._have_answered
                self._have_answered = once or states[0].answers, map_once or states[1].answers
            return self._known

    async def _check(self, query: Callable[[], object], store: Store | None = None) -> StoreState:
        reason = None
        try:
            async with asyncio.timeout(self._patience):
                await asyncio.to_thread(query)  # after a timeout the thread is abandoned
        except TimeoutError:
            reason = f"no answer within {self._patience:g} s"
        except PPaaSError as error:
            reason = str(error)
        waiting = await asyncio.to_thread(store.waiting) if isinstance(store, StoreAndForward) else 0
        return StoreState(reason is None, reason, waiting)
