"""Health of the stores, and the watch over the disk of the data folder.

The watch keeps the reserve, and logs when space runs out and when it is back.
"""

import asyncio
import logging
from collections.abc import Callable
from dataclasses import dataclass

from engine.processes.background import repeat
from engine.processes.occasional_log import OccasionalLog
from ppaas.clock import Clock, monotonic
from ppaas.errors import PPaaSError
from storage.disk_space import DiskReserve, SpaceState
from storage.ports import MapStore, Store
from storage.store_and_forward.store import StoreAndForward

logger = logging.getLogger(__name__)


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


PERIOD = 1.0
"""Time between two checks [s]."""

LOW_TEXT = "the disk of the data folder has little space left (%d MiB): free space before it is full"
FULL_TEXT = (
    "the disk of the data folder is FULL (%d MiB left): nothing new is stored until there is space again; remove maps, "
    "plans or users, or free space otherwise"
)


def _ignore(_state: SpaceState, _reason: str) -> None:
    """Do nothing: nobody is notified of the disk."""


class DiskWatch:
    """Watches the disk of a cloud.

    Parameters
    ----------
    reserve : DiskReserve, optional
        Reserve of the cloud's data folder, which this process owns; None to watch nothing.
    make_room : callable
        Called in a thread when the disk becomes full: frees space that the stores do not need.
    changed : callable
        Called with the new state of the disk and the reason when it has changed.
    """

    def __init__(
        self,
        reserve: DiskReserve | None,
        make_room: Callable[[], None] = lambda: None,
        changed: Callable[[SpaceState, str], None] = _ignore,
    ) -> None:
        self._reserve = reserve
        self._make_room = make_room
        self._changed = changed
        self._last: SpaceState = "ok"
        self._logs = {"low": OccasionalLog(logger, 24 * 3600.0), "full": OccasionalLog(logger)}

    @classmethod
    def of(
        cls, reserve: DiskReserve | None, store: Store, changed: Callable[[SpaceState, str], None] = _ignore
    ) -> "DiskWatch":
        """Return the watch of a cloud, which empties the log of its store to make room if the store has one."""
        return cls(reserve, getattr(store, "shrink_log", lambda: None), changed)

    async def run(self) -> None:
        """Check the disk until cancelled."""
        if self._reserve is not None:
            await repeat(self._look, PERIOD)

    async def _look(self) -> None:
        before = self._last
        state = await asyncio.to_thread(self.check)
        if state != before and self._reserve is not None:
            space = await asyncio.to_thread(disk_state, self._reserve)
            self._changed(state, "" if space is None else space.reason or "")

    def check(self) -> SpaceState:
        """Check the disk once; return its state. Blocks."""
        if self._reserve is None:
            return self._last
        try:
            state = self._reserve.keep()
            free = self._reserve.space().free >> 20
        except OSError as error:
            self._logs["full"].warning("the disk of the data folder cannot be measured: %s", error)
            return self._last
        if state == "full" and self._last != "full":
            self._make_room()
        if state != "ok":
            self._logs[state].warning(FULL_TEXT if state == "full" else LOW_TEXT, free)
        for name in ("full", "low"):
            if state not in (name, "full"):
                self._logs[name].is_over(f"the disk of the data folder is not {name} any more")
        self._last = state
        return state
