"""The contract of every ``WebhookStore``."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import pytest

from ppaas.errors import Conflict, InvalidInput, NotFound
from storage.ports import Store
from storage.webhooks.records import Webhook, WebhookDelivery
from tests.support.storage.records import NOT_NAMES, user


def hook(name: str = "wh-1", owner: str = "ann", **fields: object) -> Webhook:
    given = {"url": "https://example.org/é?a=1", "events": ("goal.*", "robot.lost"), "secret": bytes(range(32))}
    return Webhook(user=owner, id=name, **(given | fields))  # type: ignore[arg-type]


def delivery(name: str = "d1", owner: str = "ann", of: str = "wh-1", **fields: object) -> WebhookDelivery:
    given = {"event": "goal.reached", "body": b'{"type":"goal.reached"}', "created": 0.1 + 0.2}
    return WebhookDelivery(user=owner, hook=of, id=name, **(given | fields))  # type: ignore[arg-type]


def test_a_webhook_is_returned_as_it_was_stored(store: Store) -> None:
    given = hook(robots=("tb*",), maps=("office",), state="disabled", reason="gone", former_secret=b"\x00", created=1.5)
    store.put_webhook(given)
    assert store.webhook("ann", "wh-1") == given
    store.put_webhook(hook())
    assert store.webhook("ann", "wh-1") == hook()


def test_a_webhook_that_does_not_exist_is_not_found(store: Store) -> None:
    store.put_webhook(hook())
    for key in (("ann", "wh-2"), ("bob", "wh-1")):
        with pytest.raises(NotFound):
            store.webhook(*key)
        with pytest.raises(NotFound):
            store.remove_webhook(*key)
    assert store.webhooks("bob") == []


def test_a_webhook_is_replaced_only_if_nobody_changed_it_first(store: Store) -> None:
    with pytest.raises(Conflict):
        store.put_webhook(hook(state="paused"), instead_of=hook())
    store.put_webhook(hook())
    store.put_webhook(hook(state="paused"), instead_of=hook())
    with pytest.raises(Conflict):
        store.put_webhook(hook(url="https://other"), instead_of=hook())
    assert store.webhook("ann", "wh-1") == hook(state="paused")


def test_of_concurrent_changes_of_a_webhook_one_is_made(store: Store) -> None:
    store.put_webhook(hook())

    def change(number: int) -> bool:
        try:
            store.put_webhook(hook(description=str(number)), instead_of=hook())
        except Conflict:
            return False
        return True

    with ThreadPoolExecutor(4) as threads:
        assert sum(threads.map(change, range(12))) == 1


def test_webhooks_are_listed_by_id_and_page_by_page(store: Store) -> None:
    for name in ("wh-2", "wh-10", "wh-1"):
        store.put_webhook(hook(name))
    store.put_webhook(hook("wh-3", "bob"))
    assert [one.id for one in store.webhooks("ann")] == ["wh-1", "wh-10", "wh-2"]
    assert store.webhooks("ann", after="wh-1", limit=1) == [hook("wh-10")]
    assert store.webhooks("ann", limit=0) == []
    assert store.webhook_users() == ["ann", "bob"]


def test_deliveries_are_stored_replaced_listed_and_removed(store: Store) -> None:
    store.put_webhook(hook())
    for name in ("d2", "d10", "d1"):
        store.put_delivery(delivery(name))
    failed = delivery("d10", state="dead", attempts=10, due=7.5, reason="no answer", ended=9.0)
    store.put_delivery(failed)
    assert store.delivery("ann", "wh-1", "d10") == failed
    assert store.deliveries("ann", "wh-1") == [delivery("d1"), failed, delivery("d2")]
    assert store.deliveries("ann", "wh-1", after="d1", limit=1) == [failed]
    assert store.deliveries("ann", "wh-1", limit=0) == []
    for _ in range(2):
        store.remove_delivery("ann", "wh-1", "d10")
    assert [one.id for one in store.deliveries("ann", "wh-1", after="d1")] == ["d2"]
    with pytest.raises(NotFound):
        store.delivery("ann", "wh-1", "d10")


def test_deliveries_need_their_webhook_and_end_with_it(store: Store) -> None:
    for made in (delivery(), delivery(owner="bob")):
        with pytest.raises(NotFound, match="webhook"):
            store.put_delivery(made)
    store.put_webhook(hook())
    store.put_webhook(hook("wh-2"))
    store.put_delivery(delivery())
    store.put_delivery(delivery(of="wh-2"))
    store.remove_webhook("ann", "wh-1")
    assert store.deliveries("ann", "wh-1") == []
    assert store.deliveries("ann", "wh-2") == [delivery(of="wh-2")]
    with pytest.raises(NotFound, match="webhook"):
        store.put_delivery(delivery())
    assert store.webhooks("ann") == [hook("wh-2")]


def test_many_deliveries_come_and_go(store: Store) -> None:
    store.put_webhook(hook())
    names = [f"d{number:03}" for number in range(40)]
    for name in names:
        store.put_delivery(delivery(name))
    for name in names[::2] + names[1::2]:
        store.remove_delivery("ann", "wh-1", name)
    assert store.deliveries("ann", "wh-1") == []
    store.put_delivery(delivery("d007"))
    assert store.deliveries("ann", "wh-1") == [delivery("d007")]


def test_webhooks_of_a_removed_user_are_forgotten(store: Store) -> None:
    for name in ("ann", "bob"):
        store.add_user(user(name))
        store.put_webhook(hook(owner=name))
        store.put_delivery(delivery(owner=name))
    store.remove_user("ann")
    assert store.webhook_users() == ["bob"]
    store.add_user(user("ann"))
    assert store.webhooks("ann") == []
    store.put_webhook(hook())
    assert store.deliveries("ann", "wh-1") == []
    assert store.deliveries("bob", "wh-1") == [delivery(owner="bob")]


@pytest.mark.parametrize("name", NOT_NAMES)
def test_invalid_names_of_webhooks_are_refused(store: Store, name: str) -> None:
    calls: list[Callable[[], object]] = [lambda: store.webhooks(name)]
    for key in ((name, "wh-1", "d"), ("ann", name, "d"), ("ann", "wh-1", name)):
        calls += [
            lambda key=key: store.delivery(*key),  # type: ignore[misc]
            lambda key=key: store.remove_delivery(*key),  # type: ignore[misc]
            lambda key=key: store.put_delivery(delivery(key[2], key[0], key[1])),  # type: ignore[misc]
        ]
    for owner, of in ((name, "wh-1"), ("ann", name)):
        calls += [
            lambda owner=owner, of=of: store.put_webhook(hook(of, owner)),  # type: ignore[misc]
            lambda owner=owner, of=of: store.webhook(owner, of),  # type: ignore[misc]
            lambda owner=owner, of=of: store.remove_webhook(owner, of),  # type: ignore[misc]
        ]
    for call in calls:
        with pytest.raises(InvalidInput):
            call()
