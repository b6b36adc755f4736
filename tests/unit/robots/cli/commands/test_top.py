import json
import re
from typing import Any

import pytest

from robots.cli.commands import top
from robots.cli.commands.top import SORT_KEYS, as_text, render
from robots.client.rest import RestClient
from tests.support.cloud.command_line import CommandLine
from tests.support.endpoints.fake_cloud import container

FIRST = container("c1", cpu=0.5, pss=10 << 20, age=30.0, clients=2, connected=True)
SECOND = container("c10", robot="tb0", cpu=0.25, pss=30 << 20, age=4000.0, clients=1)  # an operator, or one that waits
THIRD = container("c2", user="bob", robot=None, kind="planning", state="starting", pid=None)


@pytest.fixture
def busy(ppaas: CommandLine) -> CommandLine:
    ppaas.cloud.running = [FIRST, SECOND, THIRD]
    return ppaas


async def test_an_administrator_sees_machines_and_all_containers(busy: CommandLine) -> None:
    ended = await busy("top", "--once", user="admin")
    assert (ended.status, ended.err) == (0, "")
    assert re.search(
        r"^\S+  1 robots connected  3 containers  CPU 75 %  memory 40.0 MiB  oldest 1h 6m$", ended.out, re.M
    )
    rows = [row for row in ended.rows if row]
    assert rows[1][:5] == ["id", "state", "cores", "capacity", "load"]
    assert rows[2][:5] == ["m1", "ready", "4", "16", "0.5"]
    assert [
        "c1",
        "robot",
        "ann",
        "tb1",
        "house",
        "m1",
        "ready",
        "yes",
        "1",
        "50",
        "%",
        "10.0",
        "MiB",
        "30s",
        "2",
    ] in rows
    assert ["c2", "planning", "bob", "-", "house", "m1", "starting", "no", "1", "-", "-", "0s", "0"] in rows


async def test_a_user_sees_only_the_own_containers_and_no_machines(busy: CommandLine) -> None:
    ended = await busy("top", "--once", "--json")
    [line] = ended.out.splitlines()
    seen = json.loads(line)
    assert seen["machines"] is None
    assert [one["id"] for one in seen["containers"]] == ["c1", "c10"]
    assert "capacity" not in (await busy("top", "--once")).out


@pytest.mark.parametrize(
    ("sort", "order"),
    [
        ("cpu", ["c1", "c10", "c2"]),
        ("memory", ["c10", "c1", "c2"]),
        ("age", ["c10", "c1", "c2"]),
        ("robot", ["c2", "c10", "c1"]),
        ("id", ["c1", "c2", "c10"]),
    ],
)
async def test_containers_are_sorted_by_the_given_key(busy: CommandLine, sort: str, order: list[str]) -> None:
    assert sort in SORT_KEYS
    ended = await busy("top", "--once", "--sort", sort, user="admin")
    assert [row[0] for row in ended.rows if row and re.fullmatch(r"c\d+", row[0])] == order


async def test_top_repeats_until_it_is_interrupted(busy: CommandLine, monkeypatch: pytest.MonkeyPatch) -> None:
    read_state, calls = top.read_state, iter(range(2))

    async def interrupted(client: RestClient) -> dict[str, Any]:
        if next(calls, None) is None:
            raise KeyboardInterrupt
        return await read_state(client)

    monkeypatch.setattr(top, "read_state", interrupted)
    ended = await busy("top", "--json", "--interval", "0.1")
    assert ended.status == 130
    assert [len(json.loads(line)["containers"]) for line in ended.out.splitlines()] == [2, 2]


@pytest.mark.parametrize("interval", ["0", "-1", "nan", "1e9", "soon"])
async def test_an_invalid_interval_is_refused(busy: CommandLine, interval: str) -> None:
    assert (await busy("top", "--once", "--interval", interval)).status == 2


def test_the_terminal_view_shows_the_same_as_the_text(capsys: pytest.CaptureFixture[str]) -> None:
    from rich.console import Console

    one: dict[str, Any] = {
        "id": "c1",
        "robot": "tb1",
        "user": "ann",
        "cpu": 0.5,
        "pss": 1 << 20,
        "age": 5.0,
        "clients": 1,
        "connected": True,
    }
    robot = {"id": "tb1", "state": "online", "battery": 0.8, "seen_ago": 0.0, "task": "Driving", "error": ""}
    seen = {"time": 0.0, "machines": None, "containers": [one], "robots": [robot]}
    console = Console(width=160)
    with console.capture() as drawn:
        console.print(render(seen, "cpu"))
    words = set(drawn.get().split())
    assert {"tb1", "50", "1.0", "MiB", "5s", "80", "now", "Driving"} <= words
    assert words - {"─" * n for n in range(1, 200)} >= set(as_text(seen, "cpu").split()) - {"-"}
