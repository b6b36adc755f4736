import functools
import logging
import subprocess
import sys

import pytest

from engine import bootstrap
from engine.bootstrap import CloudConfig, Engine
from engine.local.agent_process import AgentProcess
from engine.processes.instances import folder_of
from ppaas.errors import InvalidParameter, Unavailable


@pytest.mark.parametrize(("usual", "told"), [(0.0, True), (600.0, False)])
async def test_a_start_that_takes_longer_than_usual_says_why(tmp_path, short_path, monkeypatch, caplog, usual, told):
    monkeypatch.setattr(bootstrap, "USUAL_START", usual)
    caplog.set_level(logging.INFO)
    engine = Engine(CloudConfig(f"sqlite:///{tmp_path / 'store.sqlite'}", f"file:///{tmp_path / 'maps'}"))
    try:
        await engine.start()
        assert [machine.id for machine in engine.cloud.machines()] == ["local"]
    finally:
        await engine.close()
    assert (bootstrap.STILL_STARTING in caplog.text) is told
    assert list(short_path.iterdir()) == []


async def test_an_agent_that_only_dies_is_not_waited_for(short_path, monkeypatch):
    dies = functools.partial(AgentProcess, command=(sys.executable, "-c", "raise SystemExit(3)"))
    monkeypatch.setattr("engine.local.machine.AgentProcess", dies)
    monkeypatch.setattr(bootstrap, "LOOK", 0.05)
    engine = Engine(CloudConfig("memory:", "memory:"))
    try:
        with pytest.raises(Unavailable, match=f"its agent exited {bootstrap.HOPELESS} times"):
            await engine.start()
    finally:
        await engine.close()


async def test_priorities_that_are_none_are_refused_before_anything_is_made(short_path):
    with pytest.raises(InvalidParameter, match="node_monitor"):
        Engine(CloudConfig("memory:", "memory:", node_priorities=("luck",)))
    assert list(short_path.iterdir()) == []


@pytest.fixture
def dead_instance():
    code = "from engine.processes.instances import instance_name; print(instance_name())"
    return subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout.strip()


async def test_what_a_machine_that_had_to_be_killed_left_in_shared_memory_goes_with_the_cloud(
    short_path, dead_instance
):
    engine, left = Engine(CloudConfig("memory:", "memory:")), folder_of(dead_instance)
    left.mkdir()
    await engine.close()
    assert not left.exists()
