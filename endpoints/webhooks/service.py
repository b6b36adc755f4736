"""Service of webhooks in the process of the master: turns events into deliveries, stores them, and sends them."""

import asyncio
import logging
from collections import Counter, deque
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from typing import NamedTuple

from msgspec.structs import replace

from endpoints.audit.event import AuditEvent, AuditLog
from endpoints.webhooks.attempts import Attempts, Outcome, OutcomeKind
from endpoints.webhooks.messages import new_delivery, wants
from endpoints.webhooks.sender import WebhookSender
from endpoints.webhooks.targets import TargetRules
from engine.control.fleet_events import ALERT, GOAL_EVENTS, FleetEvent, FleetEvents
from engine.processes.occasional_log import OccasionalLog
from engine.rights.globs import matches
from ppaas.clock import Clock, epoch, monotonic
from ppaas.errors import Conflict, NotFound, Unavailable
from storage.migration.copying import one_by_one
from storage.ports import Store
from storage.webhooks.records import DeliveryState, Webhook, WebhookDelivery, WebhookState

logger = logging.getLogger(__name__)

MOST_WAITING = 1000
"""Limit of the deliveries of a webhook that wait; events beyond are given up at once."""

MOST_DEAD = 1000
"""Limit of the deliveries of a webhook that were given up and are kept; the oldest are removed first."""

MOST_HEARD = 10_000
"""Limit of the events that wait to be stored, as the store is away; events beyond are lost."""

MOST_AT_ONCE = 256
"""Limit of the attempts of all webhooks at once."""

REREAD = 300.0
"""Time between two readings of all webhooks [s]; those that an endpoint has changed are read at once."""

STORE_RETRY = 1.0
"""Time between two attempts to read or store while the store is away [s]."""

READ_AT_ONCE = 128
"""Deliveries that are read from the store at once."""

GONE_REASON = "the target answered 410, that it wants no more deliveries"
"""Why a webhook is disabled."""


RESULTS: Mapping[OutcomeKind, str] = {
    "done": "delivered", "later": "failed", "dead": "given up", "gone": "given up",
}  # fmt: skip
"""What became of an attempt, in words."""


class WebhookNumbers(NamedTuple):
    """Numbers of webhooks and of deliveries by state, of attempts by result, and of events that were lost."""

    states: Counter[WebhookState]
    deliveries: dict[DeliveryState, int]
    attempts: dict[str, int]
    lost: int


class _Stored(NamedTuple):
    """A webhook, its deliveries that wait, by due time, and those that were given up."""

    hook: Webhook
    waiting: list[tuple[float, str]]
    dead: list[str]


class Webhooks:
    """Sends the events of a cloud to the webhooks of its users; implements ``WebhookCalls``.

    Parameters
    ----------
    store : Store
    events : FleetEvents
    rules : TargetRules
    audit : AuditLog
    hear_goals : callable
        Called with the users whose robots' goals are to be reported, of all clients.
    attempts : Attempts, optional
        By default, attempts over the network.
    clock : callable
        Returns the time [s since the epoch].
    """

    def __init__(
        self,
        store: Store,
        events: FleetEvents,
        rules: TargetRules,
        audit: AuditLog,
        *,
        hear_goals: Callable[[Collection[str]], None] = lambda _: None,
        attempts: Attempts | None = None,
        clock: Clock = epoch,
    ) -> None:
        self._store = store
        self._events = events
        self._rules = rules
        self._audit = audit
        self._hear_goals = hear_goals
        self._attempts = attempts
        self._clock = clock
        self._senders: dict[tuple[str, str], WebhookSender] = {}
        self._heard: deque[FleetEvent] = deque()
        self._unstored: deque[WebhookDelivery] = deque()
        self._changed: set[str] = set()
        self._read_at = float("-inf")
        self._wake = asyncio.Event()
        self._turns = asyncio.Semaphore(MOST_AT_ONCE)
        self._results, self._lost = Counter[str](), 0
        self._losses, self._waits = OccasionalLog(logger), OccasionalLog(logger)

    def allow(self, rules: TargetRules) -> None:
        """Post to other targets from the next attempt on."""
        if rules != self._rules:
            self._rules = rules
            self._attempts = None

    # -- calls and events ----------------------------------------------------------------------------------------------

    async def check_target(self, url: str) -> None:
        """Raise ``InvalidParameter`` if a webhook may not have this URL."""
        self._rules.check(url)

    async def changed(self, user: str) -> None:
        """Read the webhooks of a user again."""
        self._changed.add(user)
        self._wake.set()

    def hear(self, event: FleetEvent) -> None:
        """Take an event."""
        if len(self._heard) >= MOST_HEARD:
            self._lost += 1
            self._losses.warning("events for webhooks are lost: the store takes none, and %d wait", MOST_HEARD)
            return
        self._heard.append(event)
        self._wake.set()

    def numbers(self) -> WebhookNumbers:
        """Return what is known of all webhooks now, and what became of attempts since this process started."""
        senders = self._senders.values()
        waiting, dead = sum(one.waiting for one in senders), sum(len(one.dead) for one in senders)
        attempts = {result: self._results[result] for result in RESULTS.values()}
        states = Counter(one.hook.state for one in senders)
        return WebhookNumbers(states, {"waiting": waiting, "dead": dead}, attempts, self._lost)

    async def run(self) -> None:
        """Send until cancelled."""
        self._events.listen(self.hear)
        try:
            while True:
                self._wake.clear()
                pause = await self._step()
                with suppress(TimeoutError):
                    async with asyncio.timeout(pause):
                        await self._wake.wait()
        finally:
            self._events.leave(self.hear)
            await asyncio.gather(*(sender.close() for sender in self._senders.values()))

    async def _step(self) -> float:
        """Do what there is to do; return the time until the next look [s]."""
        try:
            await self._read()
            while self._heard or self._unstored:
                await self._store_next()
        except Unavailable as error:
            self._waits.warning("webhooks wait for the store: %s", error)
            await asyncio.sleep(STORE_RETRY)
            return 0.0
        except Exception:
            logger.exception("an event for webhooks is dropped")
            for waiting in (self._unstored or self._heard,):
                waiting.popleft()
            await asyncio.sleep(STORE_RETRY)
            return 0.0
        return REREAD

    # -- webhooks ------------------------------------------------------------------------------------------------------

    async def _read(self) -> None:
        """Read the webhooks that were changed, or all."""
        if monotonic() - self._read_at >= REREAD:
            self._changed |= {user for user, _ in self._senders}
            self._changed |= set(await asyncio.to_thread(self._store.webhook_users))
            self._read_at = monotonic()
        elif not self._changed:
            return
        while self._changed:
            user = self._changed.pop()
            try:
                found = await asyncio.to_thread(_stored, self._store, user)
            except Unavailable:
                self._changed.add(user)
                raise
            await self._renew(user, found)
        self._hear_goals({user for (user, _), sender in self._senders.items() if _wants_goals(sender.hook)})

    async def _renew(self, user: str, found: list[_Stored]) -> None:
        known = {stored.hook.key for stored in found}
        for key in [key for key in self._senders if key[0] == user and key not in known]:
            await self._senders.pop(key).close()
        for stored in found:
            sender = self._senders.get(stored.hook.key)
            if sender is None:
                sender = self._senders[stored.hook.key] = WebhookSender(
                    stored.hook, self._attempt, self._ended, self._clock
                )
                sender.start()
            sender.renew(*stored)

    # -- events --------------------------------------------------------------------------------------------------------

    async def _store_next(self) -> None:
        """Store a delivery, or make deliveries of the next event."""
        if not self._unstored:
            event = self._heard[0]
            hooks = [sender.hook for sender in self._senders.values() if await self._is_for(sender.hook, event)]
            self._unstored.extend(new_delivery(hook, event) for hook in hooks)
            self._heard.popleft()
            return
        record = self._unstored[0]
        sender = self._senders.get((record.user, record.hook))
        if sender is not None:
            await self._keep(sender, record)
        self._unstored.popleft()

    async def _is_for(self, hook: Webhook, event: FleetEvent) -> bool:
        if (event.user and event.user != hook.user) or not wants(hook, event):
            return False
        if not event.type.startswith(ALERT):
            return True
        try:
            return (await asyncio.to_thread(self._store.user, hook.user)).role == "admin"
        except NotFound:
            return False

    async def _keep(self, sender: WebhookSender, record: WebhookDelivery) -> None:
        late = sender.waiting >= MOST_WAITING
        if late:
            text = f"{MOST_WAITING} deliveries wait already"
            record = replace(record, state="dead", reason=text, ended=self._clock())
        try:
            await asyncio.to_thread(self._store.put_delivery, record)
        except NotFound:
            return  # it was removed meanwhile
        if late:
            await self._buried(sender, record.id)
        else:
            sender.add(record.id, record.due)

    # -- attempts ------------------------------------------------------------------------------------------------------

    async def _attempt(self, hook: Webhook, name: str) -> Outcome:
        async with self._turns:
            outcome = await (await self._current_attempts()).make(hook, name)
            self._results[RESULTS[outcome.kind]] += 1
            return outcome

    async def _current_attempts(self) -> Attempts:
        if self._attempts is None:
            self._attempts = await asyncio.to_thread(_attempts_over_network, self._store, self._rules)
        return self._attempts

    async def _ended(self, sender: WebhookSender, name: str, outcome: Outcome) -> None:
        if outcome.kind != "done":
            await self._buried(sender, name)
        if outcome.kind == "gone":
            await self._disable(sender)

    async def _buried(self, sender: WebhookSender, name: str) -> None:
        """Note a delivery that was given up; remove the oldest of too many."""
        sender.dead.append(name)
        while len(sender.dead) > MOST_DEAD:
            await asyncio.to_thread(self._store.remove_delivery, *sender.hook.key, sender.dead.popleft())

    async def _disable(self, sender: WebhookSender) -> None:
        """Disable a webhook whose target is gone, and give up what waits for it."""
        hook = sender.hook
        if hook.state == "disabled":
            return
        disabled = replace(hook, state="disabled", reason=GONE_REASON)
        try:
            await asyncio.to_thread(lambda: self._store.put_webhook(disabled, instead_of=hook))
        except Conflict:
            return  # its user has changed it, or removed it
        sender.hook = disabled
        logger.warning("webhook %s of user %s is disabled: %s", hook.id, hook.user, GONE_REASON)
        self._audit.record(
            AuditEvent(
                action="disable_webhook", user=hook.user, object=f"webhooks/{hook.id}", details={"reason": GONE_REASON}
            )
        )
        for name in sender.take_all():
            await self._give_up(sender, name)

    async def _give_up(self, sender: WebhookSender, name: str) -> None:
        attempts = await self._current_attempts()
        with suppress(NotFound):
            record = await asyncio.to_thread(self._store.delivery, *sender.hook.key, name)
            await attempts.give_up(record, GONE_REASON)
            await self._buried(sender, name)


def _stored(store: Store, user: str) -> list[_Stored]:
    """Return the webhooks of a user with their deliveries. Blocks."""
    return [_stored_of(store, hook) for hook in store.webhooks(user)]


def _stored_of(store: Store, hook: Webhook) -> _Stored:
    stored = _Stored(hook, [], [])
    deliveries = one_by_one(
        lambda last: store.deliveries(*hook.key, after=last, limit=READ_AT_ONCE), "", lambda delivery: delivery.id
    )
    for delivery in deliveries:
        if delivery.state == "waiting":
            stored.waiting.append((delivery.due, delivery.id))
        elif delivery.state == "dead":
            stored.dead.append(delivery.id)
    return stored


def _wants_goals(hook: Webhook) -> bool:
    return hook.state != "disabled" and any(matches(kind, hook.events) for kind in GOAL_EVENTS.values())


def _attempts_over_network(store: Store, rules: TargetRules) -> Attempts:
    """Return attempts over the network. Blocks: it loads an HTTP client and certificates, which most clouds do not."""
    from endpoints.webhooks.posting import Poster  # noqa: PLC0415

    return Attempts(store, Poster(rules).post)
