"""`ppaas mcp` as a process, as clients start it: both generations of the protocol, and clients that misbehave."""

import asyncio
import json
import os
import signal
import sys
from asyncio.subprocess import PIPE, Process
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest
from mcp import Client, StdioServerParameters
from mcp.client.stdio import stdio_client

from ppaas import __version__
from robots import cli
from robots.cli.main import main
from robots.mcp.standard_input import LONGEST
from tests.support.cloud.served_users import ServedUsers
from tests.support.endpoints.goals_of import GoalsOf
from tests.support.endpoints.still_place import StillRobot
from tests.support.waiting import patience, until

HELLO = {
    "method": "initialize",
    "params": {"protocolVersion": "2025-06-18", "capabilities": {}, "clientInfo": {"name": "test", "version": "1"}},
}
GO = {"name": "go_to", "arguments": {"robot": "tb1", "x": 4.0, "y": 1.5, "wait": 600.0}}


def environment(url: str, token: str) -> dict[str, str]:
    return {"PPAAS_URL": url, "PPAAS_TOKEN": token, "PYTHONPATH": os.pathsep.join(sys.path)}


class RawClient:
    """Client that writes lines to a server, and reads the messages that it answers."""

    def __init__(self, process: Process) -> None:
        self.process = process

    def say(self, line: bytes) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(line + b"\n")

    def request(self, number: int, request: dict[str, Any]) -> None:
        self.say(json.dumps({"jsonrpc": "2.0", "id": number} | request).encode())

    def notify(self, method: str, **parameters: Any) -> None:
        self.say(json.dumps({"jsonrpc": "2.0", "method": method, "params": parameters}).encode())

    async def answer(self, number: int) -> dict[str, Any]:
        """Return the answer to a request; what is not one is left out."""
        assert self.process.stdout is not None
        async with patience(30.0):
            async for line in self.process.stdout:
                message: dict[str, Any] = json.loads(line)
                if message.get("id") == number:
                    return message
        raise AssertionError("the server has ended")

    async def introduce(self) -> None:
        self.request(1, HELLO)
        assert (await self.answer(1))["result"]["serverInfo"]["name"] == "ppaas"
        self.notify("notifications/initialized")


@asynccontextmanager
async def raw(served: ServedUsers, *options: str) -> AsyncIterator[RawClient]:
    """Start a server; it ends at the end of the block at the latest."""
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-m", cli.__name__, "mcp", *options, stdin=PIPE, stdout=PIPE, stderr=PIPE, limit=1 << 22,
        env=os.environ | environment(served.url, served.tokens["ann"]),
    )  # fmt: skip
    try:
        yield RawClient(process)
    finally:
        if process.returncode is None:
            process.kill()
        await process.wait()


async def ended(client: RawClient) -> tuple[int, str]:
    """Return the exit status and the log of a server that ends."""
    assert client.process.stderr is not None
    async with patience(30.0):
        log = await client.process.stderr.read()
        return await client.process.wait(), log.decode()


@pytest.mark.parametrize(("mode", "version"), [("auto", "2026-07-28"), ("legacy", "2025-11-25")])
async def test_both_generations_of_the_protocol_are_spoken(
    served: ServedUsers, place: StillRobot, tmp_path: Path, mode: str, version: str
) -> None:
    command = ["-m", cli.__name__, "mcp", "--robots", "tb1", "--read-only"]
    started = StdioServerParameters(
        command=sys.executable, args=command, env=environment(served.url, served.tokens["ann"])
    )
    with (tmp_path / "log").open("w") as log:
        async with Client(stdio_client(started, log), mode=mode) as client:
            assert client.protocol_version == version
            assert client.server_info is not None
            assert (client.server_info.name, client.server_info.version) == ("ppaas", __version__)
            assert "Begin with list_robots" in (client.instructions or "")
            answer = await client.call_tool("list_robots", {})
            assert [row["robot"] for row in answer.structured_content["robots"]] == ["tb1"]
            refused = await client.call_tool("stop_robot", {"robot": "tb1"})
            assert refused.is_error
    assert (tmp_path / "log").read_text() == ""


async def test_lines_that_are_no_requests_end_nothing(served: ServedUsers, place: StillRobot) -> None:
    async with raw(served) as client:
        await client.introduce()
        for line in (b"", b"{", b"[]", b"null", b"\xff\xfe", b'{"jsonrpc": "2.0"}', b'{"a": ' * 50_000):
            client.say(line)
        client.say(b'{"jsonrpc": "2.0", "id": 7, "method": "' + b"x" * LONGEST + b'"}')
        client.request(2, {"method": "robots/fly"})
        assert (await client.answer(2))["error"]["code"] == -32601
        client.request(3, {"method": "tools/call", "params": {"name": 3}})
        assert "error" in await client.answer(3)
        client.notify("notifications/cancelled", requestId=99)
        client.request(4, {"method": "tools/call", "params": {"name": "list_robots"}})
        answer = await client.answer(4)
        assert [row["robot"] for row in answer["result"]["structuredContent"]["robots"]] == ["tb1", "tb2"]
        assert client.process.stdin is not None
        client.process.stdin.close()
        status, log = await ended(client)
        assert status == 0
        assert f"skipped a line of more than {LONGEST} bytes" in log
        assert "Traceback" not in log


@pytest.mark.parametrize("how", ["closed", "terminated"])
async def test_who_no_longer_waits_for_a_goal_cancels_it(served: ServedUsers, place: StillRobot, how: str) -> None:
    goals = GoalsOf(place)
    async with raw(served) as client:
        await client.introduce()
        client.request(2, {"method": "tools/call", "params": GO})
        await until(lambda: goals.sent)
        client.notify("notifications/cancelled", requestId=2)
        await until(lambda: goals.cancelled)
        assert goals.cancelled == goals.sent
        client.request(3, {"method": "tools/call", "params": GO})
        await until(lambda: len(goals.sent) == 2)
        if how == "closed":
            assert client.process.stdin is not None
            client.process.stdin.close()
        else:
            client.process.send_signal(signal.SIGTERM)
        await until(lambda: len(goals.cancelled) == 2)
        assert goals.cancelled == goals.sent
        assert (await ended(client))[0] == (0 if how == "closed" else 143)


async def test_a_cloud_that_is_away_is_reported_by_each_call(served: ServedUsers) -> None:
    async with raw(served, "--url", "http://127.0.0.1:9") as client:
        await client.introduce()
        client.request(2, {"method": "tools/call", "params": GO})
        result = (await client.answer(2))["result"]
        assert result["isError"]
        assert result["content"][0]["text"].startswith("unavailable: cannot reach 127.0.0.1:9")


@pytest.mark.parametrize(
    ("options", "status", "text"),
    [
        (("--read-only", "--allow-release"), 1, "leave out --read-only"),
        (("--robots", "tb1,,tb2"), 2, "name robots, as tb1,tb2"),
        (("--token", ""), 1, "no token: export PPAAS_TOKEN"),
        (("--token", "t"), 1, "standard input must be a pipe of an MCP client"),
    ],
)
def test_what_cannot_be_served_is_refused_at_once(
    options: tuple[str, ...],
    status: int,
    text: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / "requests").write_text("{}\n")
    with (tmp_path / "requests").open() as file:
        monkeypatch.setattr("sys.stdin", file)
        try:
            found = main(["mcp", *options])
        except SystemExit as end:
            found = int(end.code or 0)
    assert found == status
    assert text in capsys.readouterr().err
