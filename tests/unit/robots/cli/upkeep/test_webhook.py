"""Command ``ppaas webhook``: webhooks from their creation to their end, and their deliveries."""

import json

import pytest
from msgspec.structs import replace

from storage.webhooks.records import Webhook
from tests.support.cloud.command_line import CommandLine

CREATE = ("webhook", "create", "https://example.org/a", "--event", "goal.*", "--robot", "tb*")


class AnyTarget:
    """Calls of a master that allows all targets."""

    async def check_target(self, url: str) -> None:
        """Accept it."""

    async def changed(self, user: str) -> None:
        """Ignore it."""


@pytest.fixture
def line(ppaas: CommandLine) -> CommandLine:
    object.__setattr__(ppaas.services, "webhooks", AnyTarget())
    return ppaas


def only(line: CommandLine) -> Webhook:
    [hook] = line.services.store.webhooks("ann")
    return hook


async def test_a_webhook_is_created_listed_changed_renewed_and_deleted(line: CommandLine) -> None:
    assert "ppaas webhook create" in (await line("webhook", "list")).out
    created = json.loads((await line(*CREATE, "--map", "office", "--description", "doors", "--paused", "--json")).out)
    name = created["id"]
    assert (created["robots"], created["maps"], created["state"]) == (["tb*"], ["office"], "paused")
    assert (await line("webhook", "list")).rows[1][:4] == [name, "https://example.org/a", "goal.*", "paused"]
    assert (await line("webhook", "resume", name)).status == 0
    assert only(line).state == "enabled"
    assert (await line("webhook", "pause", name)).status == 0
    assert only(line).state == "paused"
    changed = await line("webhook", "change", name, 'events=["robot.lost"]', "description=floor", "--json")
    assert json.loads(changed.out)["events"] == ["robot.lost"]
    renewed = (await line("webhook", "rotate", name)).rows[1]
    assert renewed[0] == name and renewed[1].startswith("whsec_") and renewed[1] != created["secret"]
    assert "former_until" in (await line("webhook", "show", name)).out
    assert (await line("webhook", "delete", name)).status == 0
    assert (await line("webhook", "show", name)).status == 1


async def test_the_secret_is_printed_once(line: CommandLine) -> None:
    row = (await line(*CREATE)).rows[1]
    assert row[0] == only(line).id and row[1].startswith("whsec_")
    for verb in (("list",), ("show", row[0])):
        assert "whsec_" not in (await line("webhook", *verb, "--json")).out


async def test_deliveries_are_sent_for_a_test_listed_replayed_and_discarded(line: CommandLine) -> None:
    await line(*CREATE)
    hook, store = only(line), line.services.store
    sent = json.loads((await line("webhook", "test", hook.id, "--json")).out)["id"]
    store.put_delivery(
        replace(store.delivery(*hook.key, sent), state="dead", attempts=10, reason="no answer", ended=1.0)
    )
    assert (await line("webhook", "deliveries", hook.id, "--state", "waiting")).out == "no such deliveries\n"
    assert (await line("webhook", "deliveries", hook.id)).rows[1][:4] == [sent, "webhook.test", "dead", "10"]
    assert (await line("webhook", "replay", hook.id, sent)).rows[1][2] == "waiting"
    assert (await line("webhook", "discard", hook.id, sent)).status == 1
    store.put_delivery(replace(store.delivery(*hook.key, sent), state="dead"))
    assert (await line("webhook", "replay", hook.id)).out == "1 deliveries are sent again\n"
    assert (await line("webhook", "replay", hook.id, "--json")).out == '{"replayed": 0}\n'
    store.put_delivery(replace(store.delivery(*hook.key, sent), state="dead"))
    assert (await line("webhook", "discard", hook.id, sent)).status == 0
    assert store.deliveries(*hook.key) == []
