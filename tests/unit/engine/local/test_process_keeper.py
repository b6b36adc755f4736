"""Named processes are kept running, replaced when they freeze, and adopted by the next keeper."""

import os
import signal
import sys
from collections.abc import AsyncIterator
from pathlib import Path

import msgspec
import pytest
from msgspec.structs import replace

from engine.local.process_keeper import ProcessKeeper, left_processes
from engine.processes.heartbeats import BeatFile
from engine.processes.instances import pid_of
from tests.support.waiting import until

BEATS = """
import json, sys, time, pathlib
from engine.processes.heartbeats import BeatFile
settings = json.load(sys.stdin)
beat = BeatFile(pathlib.Path(settings["folder"]), settings["name"])
while True:
    beat.beat()
    time.sleep(0.2)
"""
COMMAND = (sys.executable, "-c", BEATS)


def keeper(folder: Path, *names: str, extra: int = 0) -> ProcessKeeper:
    """Return the keeper of processes that show that they live."""
    settings = {name: {"folder": str(folder), "name": name, "extra": extra} for name in names}
    return ProcessKeeper(COMMAND, settings, folder, folder / "here.json")


def pids(folder: Path) -> dict[str, int]:
    """Return the ids of the processes that the next keeper would find."""
    return {left.name: pid_of(left.process) for left in left_processes(folder / "here.json")}


async def end_as_if_killed(keeper: ProcessKeeper) -> None:
    """Let a keeper keep its processes no longer, which run on."""
    for kept in keeper._kept.values():
        assert kept._keeper is not None
        kept._keeper.cancel()
    await keeper._watching.cancel()


@pytest.fixture
async def one(tmp_path: Path) -> AsyncIterator[ProcessKeeper]:
    made = keeper(tmp_path, "e-1")
    await made.start()
    await until(lambda: BeatFile(tmp_path, "e-1").last() is not None)
    yield made
    await made.stop()
    assert pids(tmp_path) == {}


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
async def test_a_process_that_dies_or_freezes_is_replaced(
    one: ProcessKeeper, tmp_path: Path, number: signal.Signals
) -> None:
    before = pids(tmp_path)["e-1"]
    os.kill(before, number)
    await until(lambda: pids(tmp_path).get("e-1") not in (before, None), 20.0)
    assert one.deaths == 1


async def test_the_next_keeper_adopts_a_process_with_the_same_settings(one: ProcessKeeper, tmp_path: Path) -> None:
    before = pids(tmp_path)
    await end_as_if_killed(one)
    following = keeper(tmp_path, "e-1")
    await following.start()
    assert pids(tmp_path) == before
    os.kill(before["e-1"], signal.SIGKILL)
    await until(lambda: pids(tmp_path).get("e-1") not in (before["e-1"], None), 20.0)
    await following.stop()


async def test_a_process_with_other_settings_is_ended_and_started_anew(one: ProcessKeeper, tmp_path: Path) -> None:
    before = pids(tmp_path)
    await end_as_if_killed(one)
    following = keeper(tmp_path, "e-1", "e-2", extra=1)
    await following.start()
    await until(lambda: len(pids(tmp_path)) == 2)
    assert before["e-1"] not in pids(tmp_path).values()
    await following.stop()


async def test_settings_that_a_process_follows_are_those_of_the_next_one(one: ProcessKeeper, tmp_path: Path) -> None:
    before = pids(tmp_path)
    one.change({"e-1": {"folder": str(tmp_path), "name": "e-1", "extra": 1}})
    assert pids(tmp_path) == before
    os.kill(before["e-1"], signal.SIGKILL)
    await until(lambda: pids(tmp_path).get("e-1") not in (before["e-1"], None), 20.0)
    before = pids(tmp_path)
    await end_as_if_killed(one)
    following = keeper(tmp_path, "e-1", extra=1)
    await following.start()
    assert pids(tmp_path) == before, "the next keeper adopts it"
    await following.stop()


async def test_a_process_of_another_release_is_ended_and_started_anew(one: ProcessKeeper, tmp_path: Path) -> None:
    before = pids(tmp_path)
    await end_as_if_killed(one)
    records = [replace(left, release="0.0.9") for left in left_processes(tmp_path / "here.json")]
    (tmp_path / "here.json").write_bytes(msgspec.json.encode(records))
    following = keeper(tmp_path, "e-1")
    await following.start()
    await until(lambda: pids(tmp_path).get("e-1") not in (before["e-1"], None))
    await following.stop()


def test_a_record_that_cannot_be_read_counts_as_empty(tmp_path: Path) -> None:
    (tmp_path / "here.json").write_text("[{")
    assert left_processes(tmp_path / "here.json") == []
