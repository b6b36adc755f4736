"""Event loop whose time is simulated: what sleeps is woken at once, in the order of its time."""

import asyncio
import selectors
from collections.abc import Coroutine
from typing import Any, TypeVar

T = TypeVar("T")


class _Waiter(selectors.SelectSelector):
    """Selector that does not wait, and counts the time for which it would have waited."""

    def __init__(self) -> None:
        super().__init__()
        self.now = 0.0

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        if timeout is None:
            raise RuntimeError("everybody waits for ever")
        self.now += max(timeout, 0.0)
        return super().select(0.0)


class VirtualLoop(asyncio.SelectorEventLoop):
    """Event loop whose time begins at 0 and passes only while everything in it sleeps."""

    def __init__(self) -> None:
        self._waiter = _Waiter()
        super().__init__(self._waiter)

    def time(self) -> float:
        """Return the simulated time [s]."""
        return self._waiter.now


def run_in_virtual_time(work: Coroutine[Any, Any, T]) -> T:
    """Run a coroutine in simulated time; no part of it may use threads or sockets."""
    with asyncio.Runner(loop_factory=VirtualLoop) as runner:
        return runner.run(work)
