import threading

import pytest

from engine.agent.entries import WARM_UP, loaded_before
from engine.container.warm_up import scripted_session
from engine.runtimes.process.runtime import ProcessRuntime
from ppaas.errors import NotFound
from tests.support.engine.launches import Reports


def test_warm_up_receives_all_topics_and_leaves_nothing_behind(short_path):
    threads = set(threading.enumerate())
    topics = scripted_session.warm_up()
    assert {"tf", "tf_static", "map", "amcl_pose", "particlecloud", "plan", "cmd_vel"} <= topics
    assert {"move_base/status", "move_base/feedback", "move_base/result", "robots"} <= topics
    assert set(threading.enumerate()) == threads
    assert not list(short_path.iterdir())


def test_refusal_of_the_container_ends_the_warm_up(monkeypatch):
    robot = scripted_session.RobotConfig("r", "no such model", (0.0, 0.0, 0.0), "dijkstra", "dwa")
    monkeypatch.setattr(scripted_session, "ROBOT", robot)
    with pytest.raises(NotFound, match="no such model"):
        scripted_session.warm_up()


def test_robot_that_never_arrives_ends_the_warm_up(monkeypatch):
    monkeypatch.setattr(scripted_session, "HASTE", 0.0)
    monkeypatch.setattr(scripted_session, "TIMEOUT", 0.5)
    with pytest.raises(TimeoutError):
        scripted_session.warm_up()


@pytest.fixture
async def runtime():
    started = ProcessRuntime(loaded_before("tests.support.engine.container_entries:live_again", WARM_UP))
    await started.start()
    yield started
    await started.close()


async def test_container_imports_no_module_after_the_warm_up(runtime, tmp_path):
    async with Reports(tmp_path) as reports:
        container = await runtime.launch(reports.launch())
        assert (await reports.next()).text == "loaded: []"
        assert await container.wait() == 0
