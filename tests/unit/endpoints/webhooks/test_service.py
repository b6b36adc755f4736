"""Webhooks in the process of the master: from an event to verified deliveries, over failures and restarts."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Any

import pytest
from msgspec.structs import replace

from endpoints.audit.event import AuditQuery, MemoryAuditLog
from endpoints.webhooks import attempts, service
from endpoints.webhooks.attempts import Attempts
from endpoints.webhooks.messages import new_delivery, new_secret, shown_secret
from endpoints.webhooks.posting import Poster
from endpoints.webhooks.sender import AT_ONCE
from endpoints.webhooks.service import Webhooks
from endpoints.webhooks.targets import TargetRules
from engine.control.fleet_events import FleetEvent, FleetEvents
from ppaas.errors import InvalidParameter, Unavailable
from storage.memory.store import MemoryStore
from storage.webhooks.records import Webhook, WebhookDelivery
from tests.support.endpoints.webhook_target import Target
from tests.support.storage.records import user
from tests.support.waiting import until

RULES = TargetRules(allow_private=True, allow_http=True)


class Hall:
    """A store with hooks of ann, and the service over it."""

    def __init__(self) -> None:
        self.store, self.audit, self.events = MemoryStore(), MemoryAuditLog(), FleetEvents()
        self.heard_users: list[set[str]] = []
        self.store.add_user(user("ann"))

    def hook(self, target: Target, name: str = "wh-1", owner: str = "ann", **fields: Any) -> Webhook:
        given: dict[str, Any] = {"url": target.url, "events": ("*",), "secret": new_secret()} | fields
        made = Webhook(user=owner, id=name, **given)
        target.secrets[:] = [shown_secret(made.secret)]
        self.store.put_webhook(made)
        return made

    @asynccontextmanager
    async def running(self, timeout: float = 15.0) -> AsyncIterator[Webhooks]:
        """Run the service, as a master that leads does."""
        made = Attempts(self.store, Poster(RULES, timeout).post)
        webhooks = Webhooks(
            self.store, self.events, RULES, self.audit, attempts=made,
            hear_goals=lambda users: self.heard_users.append(set(users)),
        )  # fmt: skip
        running = asyncio.create_task(webhooks.run())
        await until(lambda: self.heard_users or running.done())
        try:
            yield webhooks
        finally:
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)
            self.heard_users.clear()

    def report(self, kind: str = "goal.reached", **fields: Any) -> None:
        given = {"user": "ann", "robot": "tb1", "map": "office"} | fields
        self.events.report(FleetEvent(type=kind, **given))

    def stored(self, hook: str = "wh-1", owner: str = "ann") -> list[WebhookDelivery]:
        return self.store.deliveries(owner, hook)


@pytest.fixture
def hall(monkeypatch: pytest.MonkeyPatch) -> Hall:
    monkeypatch.setattr(attempts, "FIRST_DELAY", 0.01)
    monkeypatch.setattr(attempts, "FACTOR", 1.0)
    monkeypatch.setattr(attempts, "STORE_RETRY", 0.01)
    monkeypatch.setattr(service, "STORE_RETRY", 0.01)
    return Hall()


@pytest.fixture
async def target() -> AsyncIterator[Target]:
    async with Target().serving() as serving:
        yield serving
        serving.hangs = False


async def test_an_event_arrives_signed_and_nothing_stays(hall: Hall, target: Target) -> None:
    hall.hook(target)
    async with hall.running():
        hall.report(data={"goal": {"id": "g1"}})
        await target.has(1)
        await until(lambda: not hall.stored())
    [event] = target.events
    assert (event["type"], event["data"]["robot"], event["data"]["goal"]) == ("goal.reached", "tb1", {"id": "g1"})


async def test_events_go_to_the_webhooks_of_their_user_that_want_them(hall: Hall, target: Target) -> None:
    hall.hook(target, events=("goal.*",), robots=("tb*",))
    async with Target().serving() as other:
        hall.hook(other, owner="bob")
        async with hall.running():
            hall.report("task.done")
            hall.report(robot="x1")
            hall.report("goal.failed")
            await target.has(1)
            await until(lambda: not hall.stored())
        assert other.ids.total() == 0
    assert [event["type"] for event in target.events] == ["goal.failed"]


@pytest.mark.parametrize(("role", "arrive"), [("admin", 2), ("user", 1)])
async def test_alerts_go_to_administrators_alone(hall: Hall, target: Target, role: str, arrive: int) -> None:
    hall.store.change_user(user("ann", role=role))
    hall.hook(target)
    async with hall.running():
        hall.report("alert.machine_lost", user="", robot="", map="")
        hall.report("robot.lost")
        await target.has(arrive)
        await until(lambda: not hall.stored())
    assert len(target.events) == arrive


async def test_a_delivery_that_fails_is_repeated_with_its_id(hall: Hall, target: Target) -> None:
    hall.hook(target)
    target.status = lambda number: 500 if number < 4 else 204
    async with hall.running() as webhooks:
        hall.report()
        await target.has(1)
        await until(lambda: webhooks.numbers().attempts["delivered"])
        numbers = webhooks.numbers()
    assert [*target.ids.values()] == [4]
    assert numbers.attempts == {"delivered": 1, "failed": 3, "given up": 0}
    assert (numbers.states, numbers.deliveries, numbers.lost) == ({"enabled": 1}, {"waiting": 0, "dead": 0}, 0)


async def test_a_delivery_that_always_fails_is_dead_and_can_be_replayed(hall: Hall, target: Target) -> None:
    hall.hook(target)
    target.status = lambda number: 500 if number <= attempts.MOST_ATTEMPTS else 204
    async with hall.running() as webhooks:
        hall.report()
        await until(lambda: [one.state for one in hall.stored()] == ["dead"])
        [dead] = hall.stored()
        assert dead.reason == "the target answered 500"
        await until(lambda: webhooks.numbers().deliveries == {"waiting": 0, "dead": 1})
        assert webhooks.numbers().attempts["given up"] == 1
        hall.store.put_delivery(replace(dead, state="waiting", attempts=0, due=0.0, ended=None))
        await webhooks.changed("ann")
        await target.has(1)
        await until(lambda: not hall.stored())
    assert [*target.ids] == [dead.id]


async def test_deliveries_outlive_a_master(hall: Hall, target: Target) -> None:
    hall.hook(target)
    target.hangs = True
    async with hall.running():
        hall.report()
        hall.report("goal.failed")
        await until(lambda: target.ids.total() == 2)
    assert [one.state for one in hall.stored()] == ["waiting", "waiting"]
    target.hangs = False
    async with hall.running():
        await target.has(2)
        await until(lambda: not hall.stored())
    assert sorted(target.ids.values()) == [2, 2], "at least once"


async def test_a_target_that_hangs_delays_no_other(hall: Hall, target: Target) -> None:
    hall.hook(target)
    async with Target(hangs=True).serving() as hanging:
        hall.hook(hanging, "wh-2")
        async with hall.running():
            for _ in range(20):
                hall.report()
            await target.has(20)
            assert hanging.ids.total() <= AT_ONCE
            assert len(hall.stored("wh-2")) == 20
        hanging.hangs = False


async def test_a_target_that_fails_gets_one_attempt_at_a_time(hall: Hall, target: Target) -> None:
    hall.hook(target)
    target.status = lambda number: 500 if number <= 8 else 204
    async with hall.running():
        hall.report()
        await until(lambda: target.ids.total() >= 2)
        target.hangs = True
        for _ in range(5):
            hall.report()
        await until(lambda: len(hall.stored()) == 6)
        await asyncio.sleep(0.1)
        assert target.hanging == 1
        target.hangs = False
        await target.has(6)


async def test_a_target_that_is_gone_disables_its_webhook(hall: Hall, target: Target) -> None:
    hook = hall.hook(target)
    target.status = lambda _: 410
    for _ in range(6):
        hall.store.put_delivery(new_delivery(hook, FleetEvent(type="goal.reached", user="ann")))
    async with hall.running():
        await until(lambda: hall.store.webhook("ann", "wh-1").state == "disabled")
        await until(lambda: [one.state for one in hall.stored()] == ["dead"] * 6)
        hall.report()
        hall.report("goal.failed")
        await asyncio.sleep(0.05)
        assert len(hall.stored()) == 6
    assert target.ids.total() <= AT_ONCE
    assert "410" in hall.store.webhook("ann", "wh-1").reason
    [event] = hall.audit.read(AuditQuery(action="disable_webhook"))
    assert (event.user, event.object) == ("ann", "webhooks/wh-1")


async def test_a_paused_webhook_keeps_events_until_it_is_resumed(hall: Hall, target: Target) -> None:
    hook = hall.hook(target, state="paused")
    async with hall.running() as webhooks:
        hall.report()
        await until(lambda: len(hall.stored()) == 1)
        await asyncio.sleep(0.05)
        assert target.ids.total() == 0
        hall.store.put_webhook(replace(hook, state="enabled"))
        await webhooks.changed("ann")
        await target.has(1)


async def test_a_webhook_that_is_created_changed_and_removed_is_followed(hall: Hall, target: Target) -> None:
    async with hall.running() as webhooks:
        hall.report()
        hook = hall.hook(target, events=("goal.failed",))
        await webhooks.changed("ann")
        await until(lambda: {"ann"} in hall.heard_users)
        hall.report("goal.failed")
        await target.has(1)
        hall.store.put_webhook(replace(hook, events=("robot.*",)))
        await webhooks.changed("ann")
        await until(lambda: hall.heard_users[-1] == set())
        hall.report("goal.failed")
        hall.report("robot.lost")
        await target.has(2)
        hall.store.remove_webhook("ann", "wh-1")
        await webhooks.changed("ann")
        await until(lambda: not webhooks._senders)
    assert [event["type"] for event in target.events] == ["goal.failed", "robot.lost"]


async def test_waiting_and_dead_deliveries_are_bounded(
    hall: Hall, target: Target, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(service, "MOST_WAITING", 3)
    monkeypatch.setattr(service, "MOST_DEAD", 2)
    hall.hook(target, state="paused")
    async with hall.running():
        for number in range(7):
            hall.report(data={"number": number}, time=float(number))
        await until(lambda: len(hall.stored()) == 5 and b'"number":6' in hall.stored()[-1].body)
    states = [(one.body[-3:-2].decode(), one.state) for one in hall.stored()]
    assert states == [("0", "waiting"), ("1", "waiting"), ("2", "waiting"), ("5", "dead"), ("6", "dead")]
    assert hall.stored()[-1].reason == "3 deliveries wait already"


async def test_events_wait_for_the_store_and_are_bounded(
    hall: Hall, target: Target, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(service, "MOST_HEARD", 2)
    hall.hook(target)
    put: Callable[..., None] = hall.store.put_delivery

    def away(*_: object) -> None:
        raise Unavailable("the store is away")

    async with hall.running():
        monkeypatch.setattr(hall.store, "put_delivery", away)
        hall.report(robot="first")
        await until(lambda: "the store is away" in caplog.text)
        for _ in range(5):
            hall.report()
        monkeypatch.setattr(hall.store, "put_delivery", put)
        await target.has(3)
        await until(lambda: not hall.stored())
    assert len(target.events) == 3
    assert "events for webhooks are lost" in caplog.text


async def test_urls_are_checked_by_the_rules_of_the_operator(hall: Hall) -> None:
    with pytest.raises(InvalidParameter):
        await Webhooks(hall.store, hall.events, TargetRules(), hall.audit).check_target("https://127.0.0.1")


async def test_other_rules_hold_from_the_next_attempt_on(hall: Hall, target: Target) -> None:
    heard: list[object] = []
    webhooks = Webhooks(hall.store, hall.events, RULES, hall.audit, hear_goals=heard.append)
    await webhooks.check_target(target.url)
    hook = hall.hook(target)
    running = asyncio.create_task(webhooks.run())
    await until(lambda: heard)
    hall.report()
    await target.has(1)
    webhooks.allow(TargetRules())
    with pytest.raises(InvalidParameter, match="https"):
        await webhooks.check_target(target.url)
    hall.report()
    await until(lambda: any(one.attempts for one in hall.stored(hook.id)))
    assert len(target.events) == 1
    webhooks.allow(RULES)
    await target.has(2)
    running.cancel()
    await asyncio.gather(running, return_exceptions=True)
