"""Processes of joined machines, with a script instead of ``ppaas machine join``."""

import asyncio
import contextlib
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any, cast

import pytest

from benchmarks.harness import joining
from benchmarks.harness.joining import JoinedMachine
from ppaas.errors import Unavailable
from robots.client.rest import RestClient
from tests.support.waiting import patience

RUN = "print(*sys.argv[1:], flush=True); time.sleep(600)"
"""Script that writes its arguments to the log of the machine, and waits."""


class OtherMachines:
    """REST client of a cloud whose only machine is another one."""

    async def items(self, path: str) -> list[dict[str, Any]]:
        return [{"id": "local", "state": "ready"}]


@contextlib.asynccontextmanager
async def running(folder: Path, script: str = RUN, *, restarts: bool = False) -> AsyncIterator[JoinedMachine]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(joining, "MACHINE", ("-c", f"import signal, sys, time; {script}"))
        patch.setattr(joining, "RESTART", 0.0)
        machine = await JoinedMachine.start("m2", folder, "TICKET", restarts=restarts)
        try:
            await starts(folder, 1)
            yield machine
        finally:
            with contextlib.suppress(Unavailable):
                await machine.end()


async def starts(folder: Path, count: int) -> list[str]:
    """Wait until the machine has started ``count`` times; return the arguments of each start."""
    async with patience(20.0):
        while (text := (folder / "log").read_text()).count("\n") < count:
            await asyncio.sleep(0.01)
    return text.splitlines()


async def test_an_exited_machine_is_restarted_without_a_ticket_until_ended(tmp_path: Path) -> None:
    data = tmp_path / "data"
    expected = [f"join TICKET --name m2 --data {data}", f"join --name m2 --data {data}"]
    async with running(tmp_path, restarts=True) as machine:
        machine.kill()
        assert await starts(tmp_path, 2) == expected
        await machine.end()
    assert await starts(tmp_path, 2) == expected


async def test_a_machine_without_restarts_stays_killed(tmp_path: Path) -> None:
    async with running(tmp_path) as machine:
        machine.kill()
        await machine.end()
        # asyncio reports 255 if something else in this process has waited for the child.
        with pytest.raises(Unavailable, match=r"machine 'm2' did not join: status (-9|255)"):
            await machine.is_in(cast(RestClient, OtherMachines()))


async def test_a_frozen_machine_can_be_ended(tmp_path: Path) -> None:
    async with running(tmp_path) as machine:
        machine.freeze()
        await machine.end()


async def test_a_machine_that_ignores_sigterm_is_killed_and_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(joining, "END_TIMEOUT", 0.1)
    async with running(tmp_path, f"signal.signal(signal.SIGTERM, signal.SIG_IGN); {RUN}") as machine:
        with pytest.raises(Unavailable, match=r"machine m2 did not exit within 0\.1 s after SIGTERM"):
            await machine.end()
