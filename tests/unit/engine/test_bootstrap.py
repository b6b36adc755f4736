import functools
import logging
import subprocess
import sys

import pytest

from engine import bootstrap
from engine.bootstrap import CloudConfig, Engine
from engine.local.kept_process import KeptProcess
from engine.processes.instances import folder_of
from engine.specs import start_state
from ppaas.errors import InvalidParameter, Unavailable


@pytest.mark.parametrize(("usual", "explained"), [(0.0, True), (600.0, False)])
async def test_slow_start_is_explained_in_the_log(tmp_path, short_path, monkeypatch, caplog, usual, explained):
    monkeypatch.setattr(start_state, "USUAL_START", usual)
    caplog.set_level(logging.INFO)
    engine = Engine(CloudConfig(f"sqlite:///{tmp_path / 'store.sqlite'}", f"file:///{tmp_path / 'maps'}"))
    try:
        await engine.start()
        assert [machine.id for machine in await engine.cloud.machines.views()] == ["local"]
    finally:
        await engine.close()
    assert ("the first start on a computer compiles the kernels" in caplog.text.lower()) is explained
    assert list(short_path.iterdir()) == []


async def test_start_fails_if_the_agent_keeps_exiting(short_path, monkeypatch):
    dies = functools.partial(KeptProcess, command=(sys.executable, "-c", "raise SystemExit(3)"))
    monkeypatch.setattr("engine.local.machine.KeptProcess", dies)
    monkeypatch.setattr(bootstrap, "LOOK", 0.05)
    engine = Engine(CloudConfig("memory:", "memory:"))
    try:
        with pytest.raises(Unavailable, match=f"its agent exited {bootstrap.HOPELESS} times"):
            await engine.start()
    finally:
        await engine.close()


async def test_invalid_priorities_are_refused_before_any_folder_is_made(short_path):
    with pytest.raises(InvalidParameter, match="node_monitor"):
        Engine(CloudConfig("memory:", "memory:", node_priorities=("luck",)))
    assert list(short_path.iterdir()) == []


@pytest.fixture
def dead_instance():
    code = "from engine.processes.instances import instance_name; print(instance_name())"
    return subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout.strip()


async def test_closing_removes_shared_memory_of_killed_machines(short_path, dead_instance):
    engine, left = Engine(CloudConfig("memory:", "memory:")), folder_of(dead_instance)
    left.mkdir()
    await engine.close()
    assert not left.exists()
