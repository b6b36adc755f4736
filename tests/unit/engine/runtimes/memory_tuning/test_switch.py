"""Fork server and containers behave the same with and without memory tuning."""

import subprocess
import sys
from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from engine.agent.entries import WARM_UP, loaded_before
from engine.runtimes.memory_tuning import lean_python
from engine.runtimes.memory_tuning.switch import NAME, OFF
from engine.runtimes.process.runtime import ProcessRuntime
from tests.support.engine.fork_servers import stop_fork_server
from tests.support.engine.launches import Reports

BOTH = [("1", True), (OFF, False)]


@pytest.fixture
async def runtime(value: str, monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[ProcessRuntime]:
    """Return a runtime whose fork server is started with this value of the switch."""
    stop_fork_server()
    monkeypatch.setenv(NAME, value)
    started = ProcessRuntime(loaded_before("tests.support.engine.container_entries:tell_tuning", WARM_UP))
    await started.start()
    yield started
    await started.close()
    stop_fork_server()


@pytest.mark.parametrize(("value", "tuned"), BOTH)
async def test_a_container_drives_its_robot_with_tuned_memory_and_without(
    value: str, tuned: bool, runtime: ProcessRuntime, tmp_path: Path
) -> None:
    async with Reports(tmp_path) as reports:
        container = await runtime.launch(reports.launch())
        facts = dict(fact.split("=") for fact in (await reports.next()).text.split())
        assert facts == {"drove": "True", "spared": str(tuned), "without_compiler": str(tuned)}
        assert await container.wait() == 0


@pytest.mark.parametrize(("value", "options"), [("1", "('-OO',)"), (OFF, "()")])
def test_the_options_of_python_depend_on_the_switch(value: str, options: str) -> None:
    code = "from engine.runtimes.memory_tuning.lean_python import *; print(PYTHON[1:], environment({}).keys() or '')"
    command = [sys.executable, "-c", code]
    output = subprocess.run(command, env={NAME: value}, check=True, capture_output=True, text=True).stdout
    assert output.startswith(options)
    assert ("PYTHONPYCACHEPREFIX" in output) == (value != OFF)


def test_memory_is_tuned_by_default() -> None:
    code = "from engine.runtimes.memory_tuning.switch import LEAN; print(LEAN)"
    output = subprocess.run([sys.executable, "-c", code], env={}, check=True, capture_output=True, text=True).stdout
    assert output == "True\n"


def test_python_runs_without_docstrings() -> None:
    assert (sys.executable, "-OO") == lean_python.PYTHON


def test_modules_are_compiled_into_our_own_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    given = {"PYTHONDONTWRITEBYTECODE": "1", "PATH": "/bin"}
    assert lean_python.environment(given) == {"PATH": "/bin", "PYTHONPYCACHEPREFIX": str(tmp_path / "modules")}


def test_a_folder_in_the_environment_is_kept() -> None:
    assert lean_python.environment({"PYTHONPYCACHEPREFIX": "/elsewhere"}) == {"PYTHONPYCACHEPREFIX": "/elsewhere"}
