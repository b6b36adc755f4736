"""The fork server's first start, its restart after it has compiled, and the session by which it warms up."""

import os
import subprocess
import sys
import threading
from pathlib import Path

import msgspec
import pytest

import ppaas
from engine.agent.entries import WARM_UP, loaded_before
from engine.container.warm_up import first_start, scripted_session
from engine.runtimes.compilation import stamp
from engine.runtimes.process.runtime import ProcessRuntime
from ppaas.errors import NotFound
from tests.support.engine.launches import Reports
from tests.support.sources import ROOT

LAYER = "tbb"


@pytest.fixture
def notes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the folder of notes on compiled kernels, still empty."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "notes"))
    return tmp_path / "notes"


@pytest.fixture
def arguments(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the file to which a failing compiler writes its arguments."""
    file = tmp_path / "arguments"
    script = f"import sys; open({str(file)!r}, 'a').write(' '.join(sys.argv[1:]) + '\\n'); sys.exit(3)"
    monkeypatch.setattr(first_start, "COMMAND", (sys.executable, "-c", script))
    return file


def note_as_compiled(key: str) -> None:
    """Write a note that all kernels are compiled."""
    stamp.note(stamp.stamp_file(Path(ppaas.__path__[0]), key), [])


def test_failing_compiler_is_logged_and_the_start_continues(
    notes: Path, arguments: Path, caplog: pytest.LogCaptureFixture
) -> None:
    first_start.compile_missing(LAYER)
    assert arguments.read_text() == f"{os.getpid()} {LAYER}\n"
    assert "status 3" in caplog.text


@pytest.mark.parametrize("key", [LAYER, first_start._key(LAYER)])
def test_compiler_is_not_started_if_kernels_are_noted_as_compiled(notes: Path, arguments: Path, key: str) -> None:
    note_as_compiled(key)
    first_start.compile_missing(LAYER)
    assert not arguments.exists()


def test_notes_of_another_threading_layer_do_not_count(notes: Path, arguments: Path) -> None:
    note_as_compiled("serial")
    first_start.compile_missing(LAYER)
    assert arguments.exists()


def test_kernels_of_containers_are_compiled_and_noted(
    tmp_path: Path, arguments: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))  # the notes are written there, and the cache stays in place
    command = (sys.executable, "-m", first_start.__name__, str(os.getpid()), LAYER)
    subprocess.run(command, check=True, timeout=300)
    (note,) = (tmp_path / ".cache" / "ppaas").glob("*.json")
    files = [Path(file) for file in msgspec.json.decode(note.read_bytes(), type=list[str])]
    assert all(file.exists() for file in files)
    assert {"dwa", "likelihood_field", "tile_growth", "chain_code", "pose_text"} <= {
        file.name.partition(".")[0] for file in files
    }
    first_start.compile_missing(LAYER)
    assert not arguments.exists()


def test_modules_are_listed_without_compiling_kernels_of_declared_types(tmp_path: Path) -> None:
    script = (
        "from engine.container.warm_up import first_start\n"
        "from engine.runtimes.compilation import compile_pool\n"
        "print(*compile_pool._largest_first(first_start._names))\n"
    )
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    listed = subprocess.run(
        [sys.executable, "-c", script], env=environment, check=True, capture_output=True, text=True, timeout=300
    ).stdout.split()
    assert {"ppaas.costmap.kernels.obstacle", "ppaas.maps.kernels.raycast"} <= set(listed)
    assert not list(tmp_path.rglob("*.nbi"))


def test_a_compiler_that_is_killed_is_started_again(
    notes: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    starts = tmp_path / "starts"
    script = (
        f"import os; open({str(starts)!r}, 'a').write('x')\n"
        f"if len(open({str(starts)!r}).read()) < 3: os.kill(os.getpid(), 9)"
    )
    monkeypatch.setattr(first_start, "COMMAND", (sys.executable, "-c", script))
    first_start.compile_missing(LAYER)
    assert (starts.read_text(), caplog.text.count("killed by signal 9")) == ("xxx", 2)
    assert "status" not in caplog.text


def run(code: str, **environment: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", code], check=True, cwd=ROOT, env=environment, capture_output=True, text=True
    )
    return done.stdout


@pytest.mark.parametrize(("begun", "starts"), [({}, "first\nsecond\n"), ({"PPAAS_BEGUN_ANEW": "1"}, "second\n")])
def test_program_is_restarted_once_with_its_environment(begun, starts):
    code = """
import os
from engine.container.warm_up import restart
environment = dict(os.environ)
os.environ["KIND"] = "changed"
print("first" if "PPAAS_BEGUN_ANEW" not in environment else "second", flush=True)
assert environment["KIND"] == "given"
restart.restart_once(environment)
"""
    assert run(code, KIND="given", **begun) == starts


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
