"""Messages of webhooks: what the library of Standard Webhooks verifies, and which events are wanted."""

import json

import pytest
from msgspec.structs import replace
from standardwebhooks import Webhook as Receiver
from standardwebhooks import WebhookVerificationError

from endpoints.webhooks.messages import MAX_BODY, OVERLAP, headers_of, new_delivery, new_secret, shown_secret, wants
from engine.control.fleet_events import FleetEvent
from ppaas.clock import epoch
from storage.webhooks.records import Webhook

EVENT = FleetEvent(
    type="goal.reached", user="ann", robot="tb1", map="office", time=1e9 + 0.25, data={"goal": {"id": "é"}}
)


def hook(**fields: object) -> Webhook:
    given = {"user": "ann", "id": "wh-1", "url": "https://a.b", "events": ("goal.*",), "secret": new_secret()}
    return Webhook(**(given | fields))  # type: ignore[arg-type]


def test_the_library_verifies_what_is_sent() -> None:
    made = hook()
    delivery = new_delivery(made, EVENT)
    event = Receiver(shown_secret(made.secret)).verify(delivery.body, dict(headers_of(made, delivery, epoch())))
    assert event == {
        "type": "goal.reached",
        "timestamp": "2001-09-09T01:46:40.250Z",
        "data": {"user": "ann", "robot": "tb1", "map": "office", "goal": {"id": "é"}},
    }


def test_both_secrets_are_valid_during_a_rotation_and_the_new_one_alone_afterwards() -> None:
    former, now = hook(), epoch()
    renewed = replace(former, secret=new_secret(), former_secret=former.secret, former_until=now + OVERLAP)
    delivery = new_delivery(renewed, EVENT)
    during = dict(headers_of(renewed, delivery, now))
    for secret in (former.secret, renewed.secret):
        Receiver(shown_secret(secret)).verify(delivery.body, during)
    after = dict(headers_of(replace(renewed, former_until=now), delivery, now))
    Receiver(shown_secret(renewed.secret)).verify(delivery.body, after)
    with pytest.raises(WebhookVerificationError):
        Receiver(shown_secret(former.secret)).verify(delivery.body, after)


def test_a_changed_body_and_an_old_message_are_refused_by_the_library() -> None:
    made = hook()
    delivery = new_delivery(made, EVENT)
    receiver = Receiver(shown_secret(made.secret))
    with pytest.raises(WebhookVerificationError):
        receiver.verify(delivery.body.replace(b"tb1", b"tb2"), dict(headers_of(made, delivery, epoch())))
    with pytest.raises(WebhookVerificationError):
        receiver.verify(delivery.body, dict(headers_of(made, delivery, epoch() - 3600.0)))


def test_the_body_names_only_what_the_event_has() -> None:
    body = json.loads(new_delivery(hook(), FleetEvent(type="alert.machine_lost", data={"machine": "m1"})).body)
    assert body["data"] == {"machine": "m1"}


@pytest.mark.parametrize(
    ("fields", "wanted"),
    [
        ({}, True),
        ({"events": ("goal.reached",)}, True),
        ({"events": ("*",)}, True),
        ({"events": ("goal.failed", "robot.*")}, False),
        ({"robots": ("tb*",)}, True),
        ({"robots": ("x*", "y?")}, False),
        ({"maps": ("off[i]ce",)}, True),
        ({"maps": ("hall",), "robots": ("tb1",)}, False),
        ({"state": "paused"}, True),
        ({"state": "disabled"}, False),
    ],
)
def test_a_webhook_wants_the_events_that_its_globs_match(fields: dict[str, object], wanted: bool) -> None:
    assert wants(hook(**fields), EVENT) == wanted


def test_an_event_without_a_robot_passes_no_filter_by_robots() -> None:
    assert not wants(hook(robots=("*x*",)), replace(EVENT, robot=""))


def test_ids_of_deliveries_rise_with_time() -> None:
    ids = [new_delivery(hook(), replace(EVENT, time=at)).id for at in (1.0, 2.0, 1e9, 1.8e9)]
    assert ids == sorted(ids) and len(set(ids)) == 4


@pytest.mark.parametrize(("length", "whole"), [(MAX_BODY - 200, True), (MAX_BODY, False)])
def test_a_body_beyond_the_limit_names_what_it_omits(length: int, whole: bool) -> None:
    event = replace(EVENT, data={"goal": {"id": "g1", "text": "x" * length}, "reason": "long"})
    delivery = new_delivery(hook(), event)
    assert len(delivery.body) <= MAX_BODY
    about = {"user": "ann", "robot": "tb1", "map": "office"}
    assert json.loads(delivery.body)["data"] == about | (event.data if whole else {"omitted": ["goal", "reason"]})
