"""The agent of a killed cloud process is found and adopted; other processes replace both."""

import asyncio
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import pytest

from engine.agent.config import AgentConfig
from engine.local.kept_process import UNKNOWN, AdoptedProcess
from engine.local.machine import AgentRecord, LocalMachine, read_record, settle_config, write_record
from engine.processes.instances import instance_name, is_dead, name_of, pid_of
from engine.processes.run_dir import OWNER
from tests.support.waiting import until

WANTED = AgentConfig("local", "", "", "", instance_name(), "sqlite:///a", "file:///maps")


@pytest.fixture
def agent() -> Iterator[subprocess.Popen[bytes]]:
    """Return a process in place of an agent."""
    process = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"], start_new_session=True)
    yield process
    process.kill()
    process.wait()


@pytest.fixture
def dead() -> str:
    """Return the instance name of a process that has exited, in place of a cloud process."""
    code = "from engine.processes.instances import instance_name; print(instance_name())"
    return subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout.strip()


@pytest.fixture
def run_dir(short_path: Path) -> Path:
    made = short_path / "ppaas-left"
    made.mkdir()
    return made


def of(cloud: str, run_dir: Path) -> AgentConfig:
    return msgspec.structs.replace(WANTED, cloud=cloud, run_dir=str(run_dir), secret="known", control="there")


def test_an_agent_of_a_dead_cloud_process_is_adopted(
    tmp_path: Path, agent: subprocess.Popen[bytes], dead: str, run_dir: Path
) -> None:
    write_record(tmp_path / "own", agent.pid, of(dead, run_dir))
    left = read_record(tmp_path / "own")
    assert left is not None and left.pid == agent.pid and left.matching_config(WANTED) is not None
    config = settle_config(WANTED, left)
    assert (config.run_dir, config.secret, config.cloud) == (str(run_dir), "known", instance_name())
    assert (run_dir / OWNER).read_text().split() == [instance_name()]
    assert LocalMachine(config, None, left).was_adopted


def test_neither_an_agent_of_a_running_cloud_nor_a_dead_agent_is_adopted(
    tmp_path: Path, agent: subprocess.Popen[bytes], dead: str, run_dir: Path
) -> None:
    file = tmp_path / "own"
    assert read_record(file) is None
    file.write_text("rubbish")
    assert read_record(file) is None
    write_record(file, agent.pid, of(instance_name(), run_dir))
    assert read_record(file) is None, "its cloud process lives"
    write_record(file, agent.pid, of(dead, run_dir))
    agent.kill()
    agent.wait()
    assert read_record(file) is None


async def test_an_agent_with_another_configuration_is_stopped_first(
    tmp_path: Path, agent: subprocess.Popen[bytes], dead: str, run_dir: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_record(tmp_path / "own", agent.pid, of(dead, run_dir))
    left = read_record(tmp_path / "own")
    wanted = msgspec.structs.replace(WANTED, cores=1)
    assert left is not None and left.matching_config(wanted) is None
    config = settle_config(wanted, left)
    assert config.run_dir != str(run_dir) and config.secret != "known"
    machine = LocalMachine(config, tmp_path / "own", left)
    monkeypatch.setattr("engine.local.kept_process.KeptProcess.start", lambda _: asyncio.sleep(0))
    await machine.start()
    assert not machine.was_adopted and is_dead(left.process)
    await machine.stop()
    assert not (tmp_path / "own").exists()


@pytest.mark.parametrize(
    "changed",
    [{"release": "0.0.9"}, {"told": msgspec.Raw(b'{"spoken": "otherwise"}')}],
    ids=["release", "fields"],
)
async def test_an_agent_of_another_release_is_stopped_and_the_reason_logged(
    tmp_path: Path,
    agent: subprocess.Popen[bytes],
    dead: str,
    run_dir: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
    changed: dict[str, Any],
) -> None:
    write_record(tmp_path / "own", agent.pid, of(dead, run_dir))
    noted = msgspec.json.decode((tmp_path / "own").read_bytes(), type=AgentRecord)
    (tmp_path / "own").write_bytes(msgspec.json.encode(msgspec.structs.replace(noted, **changed)))
    left = read_record(tmp_path / "own")
    assert left is not None
    config = settle_config(WANTED, left)
    machine = LocalMachine(config, None, left)
    monkeypatch.setattr("engine.local.kept_process.KeptProcess.start", lambda _: asyncio.sleep(0))
    await machine.start()
    assert config.run_dir != str(run_dir) and not machine.was_adopted and is_dead(left.process)
    assert f"of release {left.release}, is stopped" in caplog.text


async def test_an_adopted_agent_is_recorded_watched_and_stopped(
    tmp_path: Path, agent: subprocess.Popen[bytes], dead: str, run_dir: Path
) -> None:
    write_record(tmp_path / "own", agent.pid, of(dead, run_dir))
    left = read_record(tmp_path / "own")
    machine = LocalMachine(settle_config(WANTED, left), tmp_path / "own", left)
    await machine.start()
    assert b"known" in (tmp_path / "own").read_bytes() and read_record(tmp_path / "own") is None, "this process runs"
    await machine.stop()
    await until(lambda: name_of(agent.pid) is None)


async def test_an_adopted_process_can_be_waited_for_and_terminated(agent: subprocess.Popen[bytes]) -> None:
    found = AdoptedProcess(agent.pid)
    waiting = asyncio.create_task(found.wait())
    await asyncio.sleep(0)
    assert found.returncode is None and not waiting.done()
    found.terminate()
    assert await waiting == found.returncode == UNKNOWN
    found.terminate()  # does nothing: the process has exited
    agent.wait()
    with pytest.raises(ProcessLookupError):
        AdoptedProcess(agent.pid)


def test_an_instance_name_contains_the_process_id() -> None:
    assert pid_of(instance_name()) == os.getpid()
    assert name_of(os.getpid()) == instance_name()
