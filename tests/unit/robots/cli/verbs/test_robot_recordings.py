"""Tests of ``ppaas robot record``: Ctrl-C and SIGTERM stop the recording and fetch its file."""

import asyncio
import os
import signal
import sys
from pathlib import Path

import pytest

from ppaas.messages.health.watching import RecorderState
from robots import cli
from robots.cli.event_loop import TERMINATED
from tests.support.cloud.command_line import CommandLine
from tests.support.recordings.kept import RECORDING, kept_recordings
from tests.support.storage import records
from tests.support.waiting import PATIENCE, patience


@pytest.fixture
def recorder(ppaas: CommandLine) -> list[str]:
    """Return the services of the recorder of ann's robot that were called."""
    ppaas.services.store.put_robot(records.robot("tb1", user="ann"))
    object.__setattr__(ppaas.services, "recordings", kept_recordings(ppaas.cloud, "ann", "tb1"))
    called: list[str] = []

    def answer(service: str) -> RecorderState:
        called.append(service)
        return RecorderState("" if "stop" in called else RECORDING)

    ppaas.cloud.recorder = answer
    return called


async def recording(ppaas: CommandLine, output: Path) -> asyncio.subprocess.Process:
    """Return a process of the command."""
    environment = os.environ | {"PPAAS_URL": ppaas.url, "PPAAS_TOKEN": ppaas.tokens["ann"]}
    command = [sys.executable, "-m", cli.__name__, "robot", "record", "tb1", "-o", str(output)]
    return await asyncio.create_subprocess_exec(*command, env=environment, stderr=asyncio.subprocess.PIPE)


@pytest.mark.parametrize("end", [signal.SIGINT, signal.SIGTERM], ids=lambda end: end.name)
async def test_a_signal_stops_the_recording_and_fetches_it(
    ppaas: CommandLine, recorder: list[str], tmp_path: Path, end: signal.Signals
) -> None:
    process = await recording(ppaas, tmp_path / "drive.mcap")
    assert process.stderr is not None
    async with patience(PATIENCE):
        assert RECORDING.encode() in await process.stderr.readline()
        process.send_signal(end)
        assert await process.wait() == 0
    assert recorder[0] == "start" and recorder[-1] == "stop"
    assert (tmp_path / "drive.mcap").read_bytes().startswith(b"\x89MCAP")


async def test_a_signal_while_the_recording_is_started_does_not_leave_it_running(
    ppaas: CommandLine, recorder: list[str], tmp_path: Path
) -> None:
    called, answer = asyncio.Event(), ppaas.cloud.nodes.recorder

    async def slow(user: str, robot: str, service: str, request: object) -> RecorderState:
        called.set()
        await asyncio.sleep(0.3 if service == "start" else 0.0)
        return await answer(user, robot, service, request)  # type: ignore[arg-type]

    ppaas.patch.setattr(ppaas.cloud.nodes, "recorder", slow)
    process = await recording(ppaas, tmp_path / "drive.mcap")
    async with patience(PATIENCE):
        await called.wait()
        process.send_signal(signal.SIGTERM)
        assert await process.wait() == 0
    assert recorder[-1] == "stop"
    assert (tmp_path / "drive.mcap").exists()


async def test_a_second_signal_ends_the_command_without_the_file(
    ppaas: CommandLine, recorder: list[str], tmp_path: Path
) -> None:
    stopping, over, answer = asyncio.Event(), asyncio.Event(), ppaas.cloud.nodes.recorder

    async def stuck(user: str, robot: str, service: str, request: object) -> RecorderState:
        if service == "stop":
            stopping.set()
            await over.wait()
        return await answer(user, robot, service, request)  # type: ignore[arg-type]

    ppaas.patch.setattr(ppaas.cloud.nodes, "recorder", stuck)
    process = await recording(ppaas, tmp_path / "drive.mcap")
    assert process.stderr is not None
    async with patience(PATIENCE):
        await process.stderr.readline()
        process.send_signal(signal.SIGTERM)
        await stopping.wait()
        process.send_signal(signal.SIGTERM)
        assert await process.wait() == TERMINATED
    over.set()
    assert not (tmp_path / "drive.mcap").exists()
