import multiprocessing
import threading

import pytest

from engine import rehearsal
from engine.runtimes.process import ProcessRuntime
from ppaas.errors import NotFound
from tests.support.launches import Reports


def test_all_that_a_clone_publishes_is_heard_and_nothing_is_left(short_path):
    threads = set(threading.enumerate())
    heard = rehearsal.rehearse()
    assert {"tf", "tf_static", "map", "amcl_pose", "particlecloud", "plan", "cmd_vel"} <= heard
    assert {"move_base/status", "move_base/feedback", "move_base/result", "robots"} <= heard
    assert set(threading.enumerate()) == threads
    assert not list(short_path.iterdir())


def test_a_container_that_refuses_ends_the_rehearsal_with_its_reason(monkeypatch):
    robot = rehearsal.RobotConfig("r", "no such model", (0.0, 0.0, 0.0), "dijkstra", "dwa")
    monkeypatch.setattr(rehearsal, "ROBOT", robot)
    with pytest.raises(NotFound, match="no such model"):
        rehearsal.rehearse()


def test_a_robot_that_never_arrives_ends_the_rehearsal(monkeypatch):
    monkeypatch.setattr(rehearsal, "HASTE", 0.0)
    monkeypatch.setattr(rehearsal, "TIMEOUT", 0.5)
    with pytest.raises(TimeoutError):
        rehearsal.rehearse()


@pytest.fixture
async def runtime():
    multiprocessing.forkserver._forkserver._stop()
    started = ProcessRuntime("tests.support.container_entries:live_again", rehearsed="engine.rehearsed")
    await started.start()
    yield started
    await started.close()
    multiprocessing.forkserver._forkserver._stop()


async def test_after_it_a_container_loads_nothing_more(runtime, tmp_path):
    async with Reports(tmp_path) as reports:
        container = await runtime.launch(reports.launch())
        assert (await reports.next()).text == "loaded: []"
        assert await container.wait() == 0
