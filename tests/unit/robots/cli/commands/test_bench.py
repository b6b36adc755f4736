"""``ppaas bench``: registered benches, and the output of their results."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from importlib.metadata import EntryPoint
from pathlib import Path
from types import ModuleType

import psutil
import pytest

from benchmarks.chaos.cloud_processes import cloud_processes
from robots import cli
from robots.cli.benches import GROUP, Measured
from robots.cli.commands import bench
from robots.cli.event_loop import TERMINATED
from robots.cli.main import main
from tests.support.sources import ROOT
from tests.support.waiting import wait_until
from tests.support.world import barn


@pytest.fixture
def install(monkeypatch: pytest.MonkeyPatch):
    """Return a function that replaces all benches, by results or by modules that cannot be loaded."""

    def put(**benches: Measured | str) -> None:
        entries = []
        for name, found in benches.items():
            path = found if isinstance(found, str) else f"bench_{name}_of_a_test"
            if isinstance(found, Measured):
                module = ModuleType(path)
                vars(module).update(HELP=f"measures {name}", configure=lambda parser: parser.add_argument("--quick"))
                vars(module).update(measure=lambda _arguments, _progress, found=found: found)
                monkeypatch.setitem(sys.modules, path, module)
            entries.append(EntryPoint(name, path, GROUP))
        monkeypatch.setattr(bench, "entry_points", lambda group: entries)

    return put


def test_results_are_a_table_for_people_and_complete_as_json(install, capsys) -> None:
    install(speed=Measured({"speed": 1.5, "note": "fast"}, [{"robot": "tb1", "speed": "1.5"}]))
    assert main(["bench", "speed"]) == 0
    assert [line.split() for line in capsys.readouterr().out.splitlines()] == [["robot", "speed"], ["tb1", "1.5"]]
    assert main(["bench", "speed", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"speed": 1.5, "note": "fast"}


def test_a_text_replaces_the_table_and_the_bench_sets_the_status(install, capsys) -> None:
    install(faults=Measured({}, text="WRONG: a zombie", status=1), nothing=Measured({}))
    assert main(["bench", "faults"]) == 1
    assert capsys.readouterr().out == "WRONG: a zombie\n"
    assert main(["bench", "nothing"]) == 0
    assert capsys.readouterr().out == ""


def test_only_the_requested_bench_is_loaded(install, capsys) -> None:
    install(speed=Measured({}), broken="package_of_nobody.bench")
    assert main(["bench", "speed"]) == 0
    with pytest.raises(SystemExit):
        main(["bench", "--help"])
    listed = capsys.readouterr().out
    assert "measures speed" in listed
    assert "needs package_of_nobody, which is not installed" in listed


def test_an_unknown_bench_is_refused_with_the_known_ones(install, capsys) -> None:
    install(speed=Measured({}), noise=Measured({}))
    with pytest.raises(SystemExit) as end:
        main(["bench", "weather"])
    assert end.value.code == 2
    message = capsys.readouterr().err
    assert "speed" in message and "noise" in message


@pytest.mark.parametrize("words", [[], ["service", "--only", "fleet"], ["--json"]])
def test_a_wheel_reports_in_one_line_where_benches_come_from(install, capsys, words: list[str]) -> None:
    install()
    assert main(["bench", *words]) == 1
    assert capsys.readouterr() == ("", f"ppaas: unavailable: {bench.WHERE}\n")


def test_the_help_of_a_wheel_tells_how_to_install_benches(install, capsys) -> None:
    install()
    with pytest.raises(SystemExit) as end:
        main(["bench", "--help"])
    assert end.value.code == 0
    assert "pip install -e . -e benchmarks" in " ".join(capsys.readouterr().out.split())


def test_the_help_of_all_commands_loads_no_bench() -> None:
    code = """
import sys
from robots.cli.main import main
try:
    main(["--help"])
except SystemExit:
    sys.exit(any(name.startswith("benchmarks") for name in sys.modules))
"""
    ended = subprocess.run([sys.executable, "-c", code], cwd=ROOT, stdout=subprocess.DEVNULL, check=False)
    assert ended.returncode == 0


pytestmark = pytest.mark.journey

TIMEOUT = 150.0


@contextmanager
def running(folder: Path, *arguments: str) -> Iterator[subprocess.Popen[bytes]]:
    """Run a command with a folder for all temporary files."""
    command = [sys.executable, "-m", cli.__name__, *arguments]
    process = subprocess.Popen(command, env=os.environ | {"TMPDIR": str(folder)}, stdout=subprocess.DEVNULL)
    try:
        yield process
    finally:
        for left in cloud_processes(folder):
            with suppress(psutil.NoSuchProcess):
                left.process.kill()
        process.wait()


def wait_for(process: subprocess.Popen[bytes], holds: Callable[[], object]) -> None:
    """Wait until a condition holds while the process runs."""

    def does_while_it_runs() -> object:
        assert process.poll() is None
        return holds()

    wait_until(does_while_it_runs, TIMEOUT)


@pytest.mark.parametrize(
    "arguments", [("bench", "service", "--only", "fleet"), ("demo", "--headless", "--robots", "1")]
)
def test_sigterm_to_a_bench_or_demo_stops_its_cloud(short_path: Path, arguments: tuple[str, ...]) -> None:
    with running(short_path, *arguments) as process:
        wait_for(process, lambda: any(short_path.glob("ppaas-*/ready.json")))
        assert {"master", "endpoint", "agent"} <= {member.kind for member in cloud_processes(short_path)}
        process.send_signal(signal.SIGTERM)
        assert process.wait(TIMEOUT) == TERMINATED
    assert cloud_processes(short_path) == []
    assert list(short_path.glob("ppaas-*")) == []


def test_sigterm_to_a_bench_stops_its_pool_of_processes(short_path: Path) -> None:
    worlds = barn.write(short_path / "worlds.json", barn.world(3), barn.world(9))
    with running(short_path, "bench", "barn", str(worlds), "--runs", "1000", "--jobs", "2") as process:
        workers = psutil.Process(process.pid).children
        wait_for(process, lambda: sum(worker.cpu_times().user > 1.0 for worker in workers()) == 2)
        process.send_signal(signal.SIGTERM)
        assert process.wait(TIMEOUT) == TERMINATED
    wait_for_none(short_path)


def wait_for_none(folder: Path) -> None:
    """Wait until no process is left; Python's resource tracker exits shortly after its process."""
    wait_until(lambda: not cloud_processes(folder), 5.0)
