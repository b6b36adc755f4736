"""Webhooks over REST: created, changed, renewed and removed by their user; deliveries listed and replayed."""

import dataclasses
from typing import Any

import httpx
import pytest
from msgspec.structs import replace

from endpoints.app import create_app
from endpoints.audit.event import AuditQuery
from endpoints.resources.services import Services
from endpoints.rest.webhooks import webhooks
from endpoints.webhooks.targets import TargetRules
from ppaas.errors import Unavailable
from storage.webhooks.records import WebhookDelivery
from tests.unit.endpoints.conftest import LogIn

PATH = "/v1/webhooks"
FILE: dict[str, Any] = {"url": "https://example.org/robots", "events": ["goal.*", "robot.lost"]}


class FakeCalls:
    """Calls of a master, which checks targets and notes whose webhooks were changed."""

    def __init__(self) -> None:
        self.changes: list[str] = []
        self.away = False

    async def check_target(self, url: str) -> None:
        TargetRules().check(url)

    async def changed(self, user: str) -> None:
        if self.away:
            raise Unavailable("the master does not answer")
        self.changes.append(user)


@pytest.fixture
def calls() -> FakeCalls:
    return FakeCalls()


@pytest.fixture
def services(services: Services, calls: FakeCalls) -> Services:
    return dataclasses.replace(services, webhooks=calls)


@pytest.fixture
async def ann(log_in: LogIn) -> dict[str, str]:
    return await log_in("ann")


async def create(client: httpx.AsyncClient, header: dict[str, str], **fields: Any) -> dict[str, Any]:
    answer = await client.post(PATH, headers=header, json=FILE | fields)
    assert answer.status_code == 201, answer.text
    assert answer.headers["cache-control"] == "no-store"
    created: dict[str, Any] = answer.json()
    return created


def dead(services: Services, hook: str, name: str = "msg_1", **fields: Any) -> WebhookDelivery:
    """Store a delivery that was given up."""
    given: dict[str, Any] = {"state": "dead", "attempts": 10, "reason": "no answer", "ended": 9.0} | fields
    made = WebhookDelivery(user="ann", hook=hook, id=name, event="goal.reached", body=b"{}", created=1.0, **given)
    services.store.put_delivery(made)
    return made


async def test_a_webhook_is_created_with_a_secret_that_is_shown_once(
    client: httpx.AsyncClient, ann: dict[str, str], calls: FakeCalls, services: Services
) -> None:
    created = await create(client, ann, robots=["tb*"], maps=["office"], description="doors", state="paused")
    secret = created.pop("secret")
    assert secret.startswith("whsec_") and len(secret) == 50
    assert (await client.get(f"{PATH}/{created['id']}", headers=ann)).json() == created
    assert (await client.get(PATH, headers=ann)).json() == {"items": [created], "next": None}
    assert created["robots"] == ["tb*"] and created["state"] == "paused"
    assert calls.changes == ["ann"]
    [event] = services.audit.read(AuditQuery(action="create_webhook"))
    assert event.object == f"webhooks/{created['id']}" and event.details["events"] == FILE["events"]
    assert secret not in str(event) and "example.org" not in str(event)


async def test_webhooks_belong_to_their_user(client: httpx.AsyncClient, ann: dict[str, str], log_in: LogIn) -> None:
    path = f"{PATH}/{(await create(client, ann))['id']}"
    for name in ("bob", "admin"):
        header = await log_in(name)
        assert (await client.get(PATH, headers=header)).json()["items"] == []
        assert (await client.get(path, headers=header)).status_code == 404
        assert (await client.patch(path, headers=header, json={"state": "paused"})).status_code == 404
        assert (await client.delete(path, headers=header)).status_code == 404
    assert (await client.get(path)).status_code == 401


@pytest.mark.parametrize(
    ("fields", "where"),
    [
        ({"url": "http://example.org"}, "operator"),
        ({"url": "https://127.0.0.1"}, "not public"),
        ({"url": "https://ann:x@example.org"}, "login"),
        ({"url": ""}, "url"),
        ({"events": []}, "events"),
        ({"events": ["goal.reachd"]}, "no type of events"),
        ({"events": ["goal.*"] * 33}, "events"),
        ({"robots": ["a/b"]}, "robots"),
        ({"state": "disabled"}, "state"),
        ({"secret": "whsec_x"}, "secret"),
    ],
)
async def test_a_webhook_that_makes_no_sense_is_refused(
    client: httpx.AsyncClient, ann: dict[str, str], fields: dict[str, Any], where: str
) -> None:
    answer = await client.post(PATH, headers=ann, json=FILE | fields)
    assert answer.status_code == 422 and where in answer.text
    assert (await client.get(PATH, headers=ann)).json()["items"] == []


async def test_a_webhook_is_changed_and_enabled_again(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services
) -> None:
    name = (await create(client, ann))["id"]
    hook = services.store.webhook("ann", name)
    services.store.put_webhook(replace(hook, state="disabled", reason="gone"))
    changed = (await client.patch(f"{PATH}/{name}", headers=ann, json={"events": ["*"], "robots": ["a"]})).json()
    assert (changed["events"], changed["robots"], changed["state"], changed["reason"]) == (
        ["*"], ["a"], "disabled", "gone"
    )  # fmt: skip
    enabled = (await client.patch(f"{PATH}/{name}", headers=ann, json={"state": "enabled"})).json()
    assert (enabled["state"], enabled["reason"]) == ("enabled", "")
    refused = await client.patch(f"{PATH}/{name}", headers=ann, json={"url": "https://10.0.0.1/"})
    assert refused.status_code == 422
    assert services.store.webhook("ann", name).secret == hook.secret


async def test_a_secret_is_renewed_and_the_former_one_kept_for_a_day(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services
) -> None:
    created = await create(client, ann)
    before = services.store.webhook("ann", created["id"])
    renewed = (await client.post(f"{PATH}/{created['id']}/secret", headers=ann)).json()
    after = services.store.webhook("ann", created["id"])
    assert renewed["secret"] != created["secret"]
    assert after.former_secret == before.secret != after.secret
    assert renewed["former_until"] == after.former_until > before.created + 86000.0


async def test_a_user_may_have_a_limited_number_of_webhooks(
    client: httpx.AsyncClient, ann: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(webhooks, "MOST_WEBHOOKS", 1)
    name = (await create(client, ann))["id"]
    assert (await client.post(PATH, headers=ann, json=FILE)).status_code == 429
    assert (await client.delete(f"{PATH}/{name}", headers=ann)).status_code == 204
    await create(client, ann)


async def test_a_test_event_is_stored_whatever_the_webhook_is_for(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services, calls: FakeCalls
) -> None:
    name = (await create(client, ann))["id"]
    sent = await client.post(f"{PATH}/{name}/test", headers=ann)
    assert sent.status_code == 202
    [delivery] = services.store.deliveries("ann", name)
    assert (delivery.id, delivery.event, delivery.state) == (sent.json()["id"], "webhook.test", "waiting")
    assert calls.changes == ["ann", "ann"]


async def test_dead_deliveries_are_listed_replayed_and_discarded(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services
) -> None:
    name = (await create(client, ann))["id"]
    path = f"{PATH}/{name}/deliveries"
    for number in range(3):
        dead(services, name, f"msg_{number}")
    dead(services, name, "msg_9", state="waiting", ended=None, due=7.0)
    listed = (await client.get(path, headers=ann, params={"limit": 3})).json()
    assert [one["id"] for one in listed["items"]] == ["msg_0", "msg_1", "msg_2"] and listed["next"]
    [waiting] = (await client.get(path, headers=ann, params={"state": "waiting"})).json()["items"]
    assert (waiting["id"], waiting["due"], waiting["body"]) == ("msg_9", 7.0, "{}")
    assert (await client.delete(f"{path}/msg_0", headers=ann)).status_code == 204
    replayed = (await client.post(f"{path}/msg_1/replay", headers=ann)).json()
    assert (replayed["state"], replayed["attempts"], replayed["ended"]) == ("waiting", 0, None)
    for refused in (
        await client.post(f"{path}/msg_1/replay", headers=ann),
        await client.delete(f"{path}/msg_9", headers=ann),
    ):
        assert refused.status_code == 409
    assert (await client.post(f"{PATH}/{name}/replay", headers=ann)).json() == {"replayed": 1}
    assert (await client.get(path, headers=ann, params={"state": "dead"})).json()["items"] == []
    assert (await client.post(f"{path}/msg_7/replay", headers=ann)).status_code == 404


async def test_changes_are_stored_while_there_is_no_master(
    client: httpx.AsyncClient, ann: dict[str, str], calls: FakeCalls
) -> None:
    name = (await create(client, ann))["id"]
    calls.away = True
    assert (await client.patch(f"{PATH}/{name}", headers=ann, json={"state": "paused"})).json()["state"] == "paused"


async def test_without_a_master_to_call_a_target_cannot_be_checked(services: Services, ann: dict[str, str]) -> None:
    alone = create_app(dataclasses.replace(services, webhooks=None))
    async with httpx.AsyncClient(transport=httpx.ASGITransport(alone), base_url="http://cloud") as client:
        assert (await client.post(PATH, headers=ann, json=FILE)).status_code == 503
