"""A standby with options that cannot work ends at once with one line."""

import asyncio
import contextlib
from pathlib import Path

import pytest

from endpoints.cli import up
from endpoints.processes.keeper import COMMAND
from endpoints.processes.leading import take_the_lead
from endpoints.processes.server import cloud_config
from engine.local.kept_process import SpareProcesses
from engine.remote.authority import STANDBY, Authority
from engine.remote.joining import Ticket
from engine.remote.machines import ADDRESS
from engine.remote.replica import MACHINES
from ppaas.errors import InvalidInput, Unavailable
from robots.cli.command_parser import CommandParser

LISTEN = ("--listen-machines", "127.0.0.1:8600")
NOBODY = Ticket("127.0.0.1", 1, "0" * 64, "secret", f"b{STANDBY}")


async def start(data: Path, *arguments: str) -> None:
    """Take the lead as ``ppaas up`` does, and give it up."""
    parser = CommandParser()
    up.configure(parser)
    parsed = parser.parse_args(["--data", str(data), "--port", "0", *arguments])
    async with contextlib.AsyncExitStack() as stack:
        spares = SpareProcesses(COMMAND)
        stack.push_async_callback(spares.close)
        leadership = await take_the_lead(parsed, cloud_config(parsed), spares, stack)
        assert leadership.leads()


@pytest.mark.parametrize(
    ("arguments", "error", "why"),
    [
        (("--standby", "--listen-machines", "127.0.0.1:0"), InvalidInput, "a port other than 0"),
        (("--standby", *LISTEN), InvalidInput, "needs a ticket of the leader once"),
        (("--standby", str(NOBODY)), InvalidInput, "give --listen-machines as well"),
        (("--standby", "nonsense", *LISTEN), InvalidInput, "not a ticket"),
        (("--standby", str(NOBODY), *LISTEN), Unavailable, "no answer at tls://127.0.0.1:1"),
    ],
)
async def test_a_standby_that_cannot_take_over_says_why(
    tmp_path: Path, arguments: tuple[str, ...], error: type[Exception], why: str
) -> None:
    with pytest.raises(error, match=why):
        await asyncio.wait_for(start(tmp_path, *arguments), 60.0)


async def test_the_first_process_leads_at_once_and_the_next_one_after_it(tmp_path: Path) -> None:
    for _ in range(2):
        await asyncio.wait_for(start(tmp_path), 60.0)
        await asyncio.wait_for(start(tmp_path, "--standby"), 60.0)


async def test_a_cloud_that_nobody_has_stood_by_for_leads_with_the_option_too(tmp_path: Path) -> None:
    Authority(tmp_path / MACHINES)
    (tmp_path / MACHINES / ADDRESS).write_text("tls://127.0.0.1:8600")
    await asyncio.wait_for(start(tmp_path, "--standby", *LISTEN), 60.0)
    assert not (tmp_path / MACHINES / ADDRESS).exists(), "a standby makes no tickets"
