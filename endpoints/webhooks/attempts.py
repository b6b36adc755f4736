"""Attempts to deliver: what becomes of a delivery after each, and when the next one is due."""

import asyncio
import logging
import random
from collections.abc import Awaitable, Callable, Mapping
from typing import Literal, NamedTuple, Protocol

from msgspec.structs import replace

from endpoints.webhooks.messages import headers_of
from ppaas.clock import Clock, epoch
from ppaas.errors import Damaged, NotFound, NotPermitted, Unavailable
from storage.webhooks.records import Webhook, WebhookDelivery, WebhookStore

logger = logging.getLogger(__name__)

FIRST_DELAY, FACTOR, LONGEST_DELAY = 5.0, 4.0, 6 * 3600.0
"""Delay after the first failure [s], its growth with each further one, and its limit [s]."""

MOST_ATTEMPTS = 10
"""Number of attempts after which a delivery is given up, ten to twenty hours after the first."""

STORE_RETRY = 1.0
"""Time between two attempts to store what became of a delivery [s]."""

GONE = 410
"""Status of a target that wants no more deliveries."""


class TargetAnswer(Protocol):
    """Answer of a target."""

    @property
    def status(self) -> int:
        """Status of HTTP."""
        ...

    @property
    def wait(self) -> float:
        """For how long it asks to wait [s]."""
        ...


Post = Callable[[str, Mapping[str, str], bytes], Awaitable[TargetAnswer]]
"""Posts headers and a body to a URL; raises ``Unavailable`` or ``NotPermitted`` if there is no answer."""


OutcomeKind = Literal["done", "later", "dead", "gone"]


class Outcome(NamedTuple):
    """What became of an attempt, and when the next one is due [s since the epoch]."""

    kind: OutcomeKind
    due: float = 0.0


class _Failed(NamedTuple):
    reason: str
    wait: float = 0.0
    gone: bool = False


def delay(attempts: int, wait: float, fraction: float) -> float:
    """Return the time until the next attempt [s].

    Parameters
    ----------
    attempts : int
        Number of attempts so far.
    wait : float
        Time for which the target asks to wait [s].
    fraction : float
        Random number from 0 to 1: the delay is between half of the longest one and that.
    """
    longest = min(FIRST_DELAY * FACTOR ** (attempts - 1), LONGEST_DELAY)
    return max(longest * (1.0 + fraction) / 2.0, wait)


class Attempts:
    """Attempts to deliver.

    Parameters
    ----------
    store : WebhookStore
    post : callable
    clock : callable
        Returns the time [s since the epoch].
    fraction : callable
        Returns a random number from 0 to 1.
    """

    def __init__(
        self, store: WebhookStore, post: Post, clock: Clock = epoch, fraction: Callable[[], float] = random.random
    ) -> None:
        self._store = store
        self._post = post
        self._clock = clock
        self._fraction = fraction

    async def make(self, hook: Webhook, name: str) -> Outcome:
        """Make an attempt, and store what becomes of the delivery."""
        try:
            record = await asyncio.to_thread(self._store.delivery, *hook.key, name)
        except (NotFound, Damaged) as error:
            logger.info("delivery %s of webhook %s is not made: %s", name, hook.id, error)
            return Outcome("done")
        except Unavailable:
            return Outcome("later", self._clock() + STORE_RETRY)
        failed = await self._failure(hook, record)
        if failed is None:
            await self._stored(lambda: self._store.remove_delivery(*record.key))
            return Outcome("done")
        return await self._note(record, failed)

    async def give_up(self, record: WebhookDelivery, reason: str) -> None:
        """Store that a delivery is not tried any more."""
        dead = replace(record, state="dead", reason=reason, ended=self._clock())
        await self._stored(lambda: self._store.put_delivery(dead))

    async def _failure(self, hook: Webhook, record: WebhookDelivery) -> _Failed | None:
        try:
            answer = await self._post(hook.url, headers_of(hook, record, self._clock()), record.body)
        except (Unavailable, NotPermitted) as error:
            return _Failed(str(error))
        if 200 <= answer.status < 300:
            return None
        not_followed = "; redirects are not followed" if 300 <= answer.status < 400 else ""
        return _Failed(f"the target answered {answer.status}{not_followed}", answer.wait, answer.status == GONE)

    async def _note(self, record: WebhookDelivery, failed: _Failed) -> Outcome:
        tried = replace(record, attempts=record.attempts + 1, reason=failed.reason)
        logger.info("attempt %d of delivery %s failed: %s", tried.attempts, record.id, failed.reason)
        if failed.gone or tried.attempts >= MOST_ATTEMPTS:
            await self.give_up(tried, failed.reason)
            return Outcome("gone" if failed.gone else "dead")
        later = replace(tried, due=self._clock() + delay(tried.attempts, failed.wait, self._fraction()))
        await self._stored(lambda: self._store.put_delivery(later))
        return Outcome("later", later.due)

    @staticmethod
    async def _stored(write: Callable[[], None]) -> None:
        """Store something, however long the store is away; nothing if the webhook was removed."""
        while True:
            try:
                await asyncio.to_thread(write)
            except NotFound:
                return
            except Unavailable as error:
                logger.debug("a delivery cannot be stored now: %s", error)
                await asyncio.sleep(STORE_RETRY)
            else:
                return
