"""Whether what the cloud stands on answers: what it cannot do now, it says before anybody meets it."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass

from ppaas.clock import Clock, monotonic
from ppaas.errors import PPaaSError
from storage.ports import MapStore, Store
from storage.store_and_forward.store import StoreAndForward

BELIEVED = 2.0
"""Seconds for which an answer is given again: however many ask, a store that suffers is not asked more often."""

PATIENCE = 3.0
"""Seconds after which a store that does not answer counts as away."""


@dataclass(frozen=True, slots=True)
class StoreState:
    """Whether a store answers, and if not, why; and how many plans wait for it on this machine."""

    answers: bool
    reason: str | None = None
    waiting: int = 0


class StoreHealthCheck:
    """Asks the stores of a cloud. For one event loop.

    Parameters
    ----------
    clock : callable
        Monotonic seconds.
    patience : float
        How long to wait for an answer [s].
    """

    def __init__(self, clock: Clock = monotonic, patience: float = PATIENCE) -> None:
        self._clock = clock
        self._patience = patience
        self._asking = asyncio.Lock()
        self._known: tuple[StoreState, StoreState] | None = None
        self._until = float("-inf")

    async def stores(self, store: Store, map_store: MapStore) -> tuple[StoreState, StoreState]:
        """Return how the store for all but maps does, and that for maps."""
        async with self._asking:
            if self._known is None or self._clock() >= self._until:
                states = await asyncio.gather(
                    self._ask(lambda: store.users(limit=1), store), self._ask(lambda: map_store.maps(limit=1))
                )
                self._known, self._until = (states[0], states[1]), self._clock() + BELIEVED
            return self._known

    async def _ask(self, question: Callable[[], object], store: Store | None = None) -> StoreState:
        reason = None
        try:
            async with asyncio.timeout(self._patience):
                await asyncio.to_thread(question)  # a thread that waits too long is left to itself
        except TimeoutError:
            reason = f"no answer within {self._patience:g} s"
        except PPaaSError as error:
            reason = str(error)
        waiting = await asyncio.to_thread(store.waiting) if isinstance(store, StoreAndForward) else 0
        return StoreState(reason is None, reason, waiting)
