"""Sender of one webhook: its deliveries in memory, by their names alone, and the attempts that are being made."""

import asyncio
import heapq
from collections import deque
from collections.abc import Awaitable, Callable, Iterable
from contextlib import suppress

from endpoints.webhooks.attempts import Outcome
from engine.processes.background import Background
from ppaas.clock import Clock, epoch
from storage.webhooks.records import Webhook

AT_ONCE = 4
"""Largest number of attempts of a webhook at once; 1 after one that failed, until another succeeds."""

LONGEST_SLEEP = 60.0
"""Time after which due deliveries are looked for in any case [s]: the clock may have been set."""


class WebhookSender:
    """Sends the deliveries of a webhook when they are due.

    Parameters
    ----------
    hook : Webhook
    attempt : callable
        Makes an attempt; returns what becomes of the delivery.
    ended : callable
        Called after an attempt after which there is no other: with this sender, the delivery and the outcome.
    clock : callable
        Returns the time [s since the epoch].

    Attributes
    ----------
    hook : Webhook
    dead : deque of str
        Deliveries that were given up, oldest first.
    """

    def __init__(
        self,
        hook: Webhook,
        attempt: Callable[[Webhook, str], Awaitable[Outcome]],
        ended: Callable[["WebhookSender", str, Outcome], Awaitable[None]],
        clock: Clock = epoch,
    ) -> None:
        self.hook = hook
        self.dead: deque[str] = deque()
        self._attempt = attempt
        self._ended = ended
        self._clock = clock
        self._due: list[tuple[float, str]] = []
        self._known: set[str] = set()
        self._running = 0
        self._fails = self._is_gone = False
        self._wake = asyncio.Event()
        self._background = Background()

    @property
    def waiting(self) -> int:
        """Number of deliveries that wait, or for which an attempt is being made."""
        return len(self._known)

    def start(self) -> None:
        """Start to send."""
        self._background.run(self._run())

    async def close(self) -> None:
        """Stop; deliveries stay in the store."""
        await self._background.cancel()

    def renew(self, hook: Webhook, waiting: Iterable[tuple[float, str]], dead: Iterable[str]) -> None:
        """Take what is stored of the webhook and of its deliveries: those that wait, by time, and those given up."""
        self.hook, self._is_gone = hook, False
        self.dead = deque(dead)
        for due, name in waiting:
            self.add(name, due)
        self._wake.set()

    def add(self, name: str, due: float) -> None:
        """Send a delivery that is stored, when it is due [s since the epoch]."""
        if name not in self._known:
            self._known.add(name)
            heapq.heappush(self._due, (due, name))
            self._wake.set()

    def take_all(self) -> list[str]:
        """Return the deliveries that wait, which are not sent any more."""
        names = [name for _, name in sorted(self._due)]
        self._due.clear()
        self._known.difference_update(names)
        return names

    # -- sending -------------------------------------------------------------------------------------------------------

    async def _run(self) -> None:
        while True:
            self._wake.clear()
            pause = self._start_due()
            with suppress(TimeoutError):
                async with asyncio.timeout(pause):
                    await self._wake.wait()

    def _start_due(self) -> float:
        """Start the attempts that are due; return the time until the next look [s]."""
        if self.hook.state != "enabled" or self._is_gone:
            return LONGEST_SLEEP
        while self._due and self._running < (1 if self._fails else AT_ONCE):
            due, name = self._due[0]
            if due > self._clock():
                return min(due - self._clock(), LONGEST_SLEEP)
            heapq.heappop(self._due)
            self._running += 1
            self._background.run(self._send(name))
        return LONGEST_SLEEP

    async def _send(self, name: str) -> None:
        outcome = Outcome("later", self._clock() + LONGEST_SLEEP)  # after a fault of ours
        try:
            outcome = await self._attempt(self.hook, name)
        finally:
            self._running -= 1
            self._known.discard(name)
            self._fails, self._is_gone = outcome.kind != "done", self._is_gone or outcome.kind == "gone"
            if outcome.kind == "later":
                self.add(name, outcome.due)
            self._wake.set()
        if outcome.kind != "later":
            await self._ended(self, name, outcome)
