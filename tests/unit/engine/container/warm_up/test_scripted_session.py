import multiprocessing
import threading

import pytest

from engine.agent.entries import WARM_UP, loaded_before
from engine.container.warm_up import scripted_session
from engine.runtimes.process.runtime import ProcessRuntime
from ppaas.errors import NotFound
from tests.support.engine.launches import Reports


def test_all_that_a_clone_publishes_is_heard_and_nothing_is_left(short_path):
    threads = set(threading.enumerate())
    heard = scripted_session.warm_up()
    assert {"tf", "tf_static", "map", "amcl_pose", "particlecloud", "plan", "cmd_vel"} <= heard
    assert {"move_base/status", "move_base/feedback", "move_base/result", "robots"} <= heard
    assert set(threading.enumerate()) == threads
    assert not list(short_path.iterdir())


def test_a_container_that_refuses_ends_the_warm_up_with_its_reason(monkeypatch):
    robot = scripted_session.RobotConfig("r", "no such model", (0.0, 0.0, 0.0), "dijkstra", "dwa")
    monkeypatch.setattr(scripted_session, "ROBOT", robot)
    with pytest.raises(NotFound, match="no such model"):
        scripted_session.warm_up()


def test_a_robot_that_never_arrives_ends_the_warm_up(monkeypatch):
    monkeypatch.setattr(scripted_session, "HASTE", 0.0)
    monkeypatch.setattr(scripted_session, "TIMEOUT", 0.5)
    with pytest.raises(TimeoutError):
        scripted_session.warm_up()


@pytest.fixture
async def runtime():
    multiprocessing.forkserver._forkserver._stop()
    started = ProcessRuntime(loaded_before("tests.support.engine.container_entries:live_again", WARM_UP))
    await started.start()
    yield started
    await started.close()
    multiprocessing.forkserver._forkserver._stop()


async def test_after_it_a_container_loads_nothing_more(runtime, tmp_path):
    async with Reports(tmp_path) as reports:
        container = await runtime.launch(reports.launch())
        assert (await reports.next()).text == "loaded: []"
        assert await container.wait() == 0
