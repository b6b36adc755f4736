"""webhooks.md: its commands are typed at a cloud, its example is verified, and its numbers are those of the code."""

import asyncio
import json
import re
from pathlib import Path

import pytest
from standardwebhooks import Webhook as Receiver

from endpoints.rest.webhooks import schemas, webhooks
from endpoints.webhooks import attempts, messages, posting, sender, service, targets
from engine.control import fleet_events
from tests.support.cloud.command_line import CommandLine
from tests.support.documents import blocks, script, table, text_of
from tests.unit.robots.cli.conftest import ppaas
from tests.unit.robots.cli.upkeep.test_webhook import line

__all__ = ["line", "ppaas"]

PAGE = "docs/webhooks.md"


def page() -> str:
    return " ".join(text_of(PAGE).split())


def test_all_events_are_listed() -> None:
    rows = table(PAGE, "type", "when")
    named = [name for types, _ in rows for name in re.findall(r"[a-z]+\.[a-z_]+", types)]
    assert sorted(named) == sorted({*fleet_events.EVENT_TYPES, messages.TEST})


def test_numbers_are_those_of_the_code() -> None:
    text = page()
    limits = {what: limit for limit, what, _ in table(PAGE, "limit", "of", "beyond it")}
    assert [*limits.values()] == [
        str(webhooks.MOST_WEBHOOKS), str(schemas.MAX_EVENTS), str(service.MOST_WAITING), str(service.MOST_DEAD),
        f"{messages.MAX_BODY >> 10} KiB", f"{service.MOST_HEARD:,}", f"{targets.MAX_URL} characters",
    ]  # fmt: skip
    delays = [attempts.delay(number, 0.0, 1.0) for number in range(1, attempts.MOST_ATTEMPTS)]
    assert delays[:3] == [5.0, 20.0, 80.0] and attempts.LONGEST_DELAY == posting.LONGEST_WAIT == 6 * 3600.0
    assert f"After {attempts.MOST_ATTEMPTS} attempts" in text
    assert f"ends after {posting.TIMEOUT:g} s without an answer" in text
    assert f"A webhook has {sender.AT_ONCE} attempts at once" in text
    assert f"all webhooks together {service.MOST_AT_ONCE}" in text
    assert f"for {fleet_events.LOST_AFTER:g} s" in text
    assert messages.OVERLAP == 24 * 3600.0


def test_the_example_has_the_form_of_what_is_sent() -> None:
    [example] = blocks(PAGE, "http")
    head, _, body = example.partition("\n\n")
    sent = json.loads(body)
    assert sent.keys() == {"type", "timestamp", "data"} and sent["type"] in fleet_events.EVENT_TYPES
    assert {"webhook-id", "webhook-timestamp", "webhook-signature"} <= set(
        re.findall(r"^([\w-]+):", head, re.MULTILINE)
    )
    [code] = blocks(PAGE, "python")
    assert "from standardwebhooks import Webhook" in code and hasattr(Receiver, "verify")


async def test_the_commands_work(line: CommandLine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Type the commands with the ids that a webhook and its delivery have."""
    typed = [words.split() for words in script(PAGE).splitlines() if words.startswith("ppaas")]
    assert typed[0][:3] == ["ppaas", "webhook", "create"]
    assert (await line(*(word.strip("'") for word in typed[0][1:]))).status == 0
    [hook] = line.services.store.webhooks("ann")
    assert (hook.events, hook.robots) == (("goal.*", "robot.lost"), ("tb*",))
    sent = json.loads((await line("webhook", "test", hook.id, "--json")).out)["id"]
    names = {"ID": hook.id, "DELIVERY": sent}
    for words in typed[1:]:
        await asyncio.to_thread(_give_up, line, hook.id, sent)
        ended = await line(*(names.get(word, word) for word in words[1:]))
        assert ended.status == 0, (words, ended.err)


def _give_up(line: CommandLine, hook: str, delivery: str) -> None:
    from msgspec.structs import replace

    store = line.services.store
    store.put_delivery(replace(store.delivery("ann", hook, delivery), state="dead", ended=1.0))
