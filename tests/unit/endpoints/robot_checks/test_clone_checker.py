"""The process that checks clones: kept, timed out, killed, and ended."""

import asyncio
import os
import signal
import sys
from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from endpoints.rest.robots.schemas import RobotFile
from endpoints.robot_checks import clone_checker
from endpoints.robot_checks.clone_checker import CloneChecker
from engine.specs.clone_to_check import DEFAULTS, CloneToCheck
from ppaas.errors import RobotFault, Unavailable
from tests.support.engine.specs import robot_config

SCRIPT = """
import json, os, sys, time
with open(os.environ["STARTS"], "a") as starts:
    print(os.getpid(), file=starts)
print(flush=True)
for line in sys.stdin:
    model = json.loads(line)["robot"]["model"]
    if model == "hang":
        time.sleep(600)
    if model == "die":
        os._exit(3)
    print(json.dumps([["model", model]]) if model != "good" else "[]", flush=True)
"""


@pytest.fixture
def starts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("STARTS", str(tmp_path / "starts"))
    monkeypatch.setattr(clone_checker, "PROGRAM", ("-c", SCRIPT))
    (tmp_path / "starts").touch()
    return tmp_path / "starts"


@pytest.fixture
async def checker(starts: Path, tmp_path: Path) -> AsyncIterator[CloneChecker]:
    checker = CloneChecker(tmp_path)
    yield checker
    await checker.close()


def clone(model: str, robot: str = "tb1") -> CloneToCheck:
    return CloneToCheck(robot_config(robot, model=model), 0.05)


def pids(starts: Path) -> list[int]:
    return [int(line) for line in starts.read_text().split()]


async def test_one_process_checks_all_files(checker: CloneChecker, starts: Path) -> None:
    found = await asyncio.gather(*(checker.faults(clone(f"m{number}")) for number in range(50)))
    assert found == [[RobotFault("model", f"m{number}")] for number in range(50)]
    assert len(pids(starts)) == 1


async def test_an_accepted_file_of_another_robot_is_not_checked_again(checker: CloneChecker, starts: Path) -> None:
    assert await checker.faults(clone("good")) == []
    os.kill(pids(starts)[0], signal.SIGKILL)
    assert await checker.faults(clone("good", "tb2")) == []
    assert len(pids(starts)) == 1


async def test_a_file_of_defaults_starts_no_process(checker: CloneChecker, starts: Path) -> None:
    usual = RobotFile(map="house")
    assert {name: getattr(usual, name) for name in DEFAULTS} == DEFAULTS
    assert await checker.faults(CloneToCheck(robot_config(**DEFAULTS), 0.05)) == []
    assert pids(starts) == []


async def test_a_killed_process_is_replaced(checker: CloneChecker, starts: Path) -> None:
    await checker.faults(clone("a"))
    os.kill(pids(starts)[0], signal.SIGKILL)
    assert await checker.faults(clone("b")) == [RobotFault("model", "b")]
    assert len(pids(starts)) == 2


async def test_a_file_that_ends_the_process_is_unavailable_and_the_next_is_checked(checker: CloneChecker) -> None:
    with pytest.raises(Unavailable, match="exited: try again"):
        await checker.faults(clone("die"))
    assert await checker.faults(clone("b")) == [RobotFault("model", "b")]


async def test_a_check_that_hangs_ends_at_the_time_limit(
    checker: CloneChecker, monkeypatch: pytest.MonkeyPatch
) -> None:
    await checker.faults(clone("a"))
    with monkeypatch.context() as hurried:
        hurried.setattr(checker, "_seconds", 0.05)
        with pytest.raises(Unavailable, match=r"not checked within 0.05 s"):
            await checker.faults(clone("hang"))
    assert await checker.faults(clone("b")) == [RobotFault("model", "b")]


async def test_a_start_that_takes_long_goes_on_for_the_next_file(
    checker: CloneChecker, starts: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as hurried:
        hurried.setattr(checker, "_seconds", 0.0)
        with pytest.raises(Unavailable, match="try again"):
            await checker.faults(clone("a"))
    assert await checker.faults(clone("b")) == [RobotFault("model", "b")]
    assert len(pids(starts)) == 1


async def test_a_process_that_cannot_be_started_is_unavailable(
    checker: CloneChecker, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as without:
        without.setattr(sys, "executable", "/no/such/python")
        with pytest.raises(Unavailable, match="cannot be started"):
            await checker.faults(clone("a"))
    assert await checker.faults(clone("b")) == [RobotFault("model", "b")]


async def test_the_process_ends_when_it_is_idle_and_with_the_checker(starts: Path, tmp_path: Path) -> None:
    checker = CloneChecker(tmp_path, idle=0.0)
    await checker.faults(clone("a"))
    process = checker._process
    if process is not None:
        await process.result().wait()
    assert await checker.faults(clone("b")) == [RobotFault("model", "b")]
    await checker.close()
    for pid in pids(starts):
        with pytest.raises(ProcessLookupError):
            os.kill(pid, 0)
