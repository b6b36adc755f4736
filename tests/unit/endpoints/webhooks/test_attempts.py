"""Attempts to deliver: what becomes of a delivery, and when the next attempt is due."""

from collections.abc import Callable, Mapping
from typing import Any

import pytest

from endpoints.webhooks import attempts
from endpoints.webhooks.attempts import LONGEST_DELAY, MOST_ATTEMPTS, Attempts, Outcome, delay
from endpoints.webhooks.posting import PostAnswer
from ppaas.clock import ManualClock
from ppaas.errors import Damaged, NotFound, NotPermitted, Unavailable
from storage.memory.store import MemoryStore
from storage.webhooks.records import Webhook, WebhookDelivery

HOOK = Webhook(user="ann", id="wh-1", url="https://a.b", events=("*",), secret=b"s" * 32)
DELIVERY = WebhookDelivery(user="ann", hook="wh-1", id="msg_1", event="goal.reached", body=b"{}", created=5.0)


class Scene:
    """A store with a delivery, and a target that answers as the test sets it."""

    def __init__(self) -> None:
        self.store, self.clock = MemoryStore(), ManualClock(1000.0)
        self.store.put_webhook(HOOK)
        self.store.put_delivery(DELIVERY)
        self.answer: Callable[[], PostAnswer] = lambda: PostAnswer(204, 0.0)
        self.posted: list[str] = []
        self.attempts = Attempts(self.store, self.post, self.clock, lambda: 1.0)

    async def post(self, url: str, headers: Mapping[str, str], body: bytes) -> PostAnswer:
        assert (url, body) == (HOOK.url, b"{}")
        self.posted.append(headers["webhook-id"])
        return self.answer()

    async def make(self) -> Outcome:
        return await self.attempts.make(HOOK, "msg_1")

    @property
    def stored(self) -> WebhookDelivery:
        return self.store.delivery("ann", "wh-1", "msg_1")


@pytest.fixture
def scene(monkeypatch: pytest.MonkeyPatch) -> Scene:
    monkeypatch.setattr(attempts, "STORE_RETRY", 0.001)
    return Scene()


def fails(error: Exception) -> Callable[[], PostAnswer]:
    def answer() -> PostAnswer:
        raise error

    return answer


@pytest.mark.parametrize("status", [200, 202, 204, 299])
async def test_a_delivery_that_is_answered_with_2xx_is_done(scene: Scene, status: int) -> None:
    scene.answer = lambda: PostAnswer(status, 0.0)
    assert (await scene.make()).kind == "done"
    assert scene.store.deliveries("ann", "wh-1") == []


@pytest.mark.parametrize(
    ("answer", "reason"),
    [
        (lambda: PostAnswer(500, 0.0), "the target answered 500"),
        (lambda: PostAnswer(301, 0.0), "the target answered 301; redirects are not followed"),
        (lambda: PostAnswer(100, 0.0), "the target answered 100"),
        (fails(Unavailable("no answer within 15 s")), "no answer within 15 s"),
        (fails(NotPermitted("a.b has no public address")), "a.b has no public address"),
    ],
)
async def test_a_delivery_that_fails_is_tried_later(
    scene: Scene, answer: Callable[[], PostAnswer], reason: str
) -> None:
    scene.answer = answer
    assert await scene.make() == Outcome("later", 1005.0)
    assert (scene.stored.attempts, scene.stored.due, scene.stored.reason) == (1, 1005.0, reason)
    scene.clock.advance(5.0)
    assert await scene.make() == Outcome("later", 1025.0)
    assert scene.posted == ["msg_1", "msg_1"], "with the same id"


async def test_a_target_that_asks_to_wait_is_left_alone_for_that_time(scene: Scene) -> None:
    scene.answer = lambda: PostAnswer(429, 300.0)
    assert await scene.make() == Outcome("later", 1300.0)


async def test_a_delivery_is_given_up_after_the_last_attempt(scene: Scene) -> None:
    scene.answer = lambda: PostAnswer(503, 0.0)
    kinds = [(await scene.make()).kind for _ in range(MOST_ATTEMPTS)]
    assert kinds == ["later"] * (MOST_ATTEMPTS - 1) + ["dead"]
    assert (scene.stored.state, scene.stored.ended, scene.stored.attempts) == ("dead", 1000.0, MOST_ATTEMPTS)


async def test_a_target_that_is_gone_ends_its_delivery_at_once(scene: Scene) -> None:
    scene.answer = lambda: PostAnswer(410, 0.0)
    assert (await scene.make()).kind == "gone"
    assert scene.stored.state == "dead"


async def test_a_delivery_that_was_removed_is_not_made(scene: Scene) -> None:
    scene.store.remove_delivery("ann", "wh-1", "msg_1")
    assert (await scene.make()).kind == "done"
    assert scene.posted == []


async def test_an_attempt_waits_for_the_store(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    read = scene.store.delivery

    def away(*_: object) -> Any:
        raise Unavailable("the store is away")

    monkeypatch.setattr(scene.store, "delivery", away)
    assert (await scene.make()).kind == "later"
    assert scene.posted == []
    monkeypatch.setattr(scene.store, "delivery", read)
    remove, left = scene.store.remove_delivery, [3]

    def removed(*key: str) -> None:
        left[0] -= 1
        if left[0]:
            away()
        remove(*key)

    monkeypatch.setattr(scene.store, "remove_delivery", removed)
    assert (await scene.make()).kind == "done"
    assert scene.posted == ["msg_1"] and scene.store.deliveries("ann", "wh-1") == []


async def test_a_webhook_that_is_removed_during_an_attempt_takes_its_delivery_along(scene: Scene) -> None:
    def answer() -> PostAnswer:
        scene.store.remove_webhook("ann", "wh-1")
        return PostAnswer(500, 0.0)

    scene.answer = answer
    await scene.make()
    with pytest.raises(NotFound):
        _ = scene.stored


def test_delays_grow_and_are_spread() -> None:
    longest = [delay(number, 0.0, 1.0) for number in range(1, MOST_ATTEMPTS)]
    assert longest == [5.0, 20.0, 80.0, 320.0, 1280.0, 5120.0, 20480.0, LONGEST_DELAY, LONGEST_DELAY]
    assert [delay(number, 0.0, 0.0) for number in range(1, MOST_ATTEMPTS)] == [one / 2.0 for one in longest]
    assert 9.0 < sum(longest) / 2.0 / 3600.0 < sum(longest) / 3600.0 < 20.0


async def test_a_damaged_record_is_dropped(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    def damaged(*_: object) -> Any:
        raise Damaged("webhook_deliveries/ann/wh-1/msg_1 is damaged")

    monkeypatch.setattr(scene.store, "delivery", damaged)
    assert (await scene.make()).kind == "done"
