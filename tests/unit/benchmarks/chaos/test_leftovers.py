"""Leftovers of a cloud's processes are found, and those of other processes are ignored."""

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from benchmarks.chaos.cloud_processes import MACHINES, OWN, STANDBY, ZOMBIE_GRACE, Leftovers, cloud_processes
from ppaas.clock import ManualClock

WAIT = "import sys; sys.stdin.read()"


def start(folder: Path, code: str = WAIT, *arguments: str) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-c", code, *arguments], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        env=os.environ | {"TMPDIR": str(folder)},
    )  # fmt: skip


@pytest.fixture
def reported() -> list[str]:
    """Return the reported leftovers."""
    return []


@pytest.fixture
def traces(tmp_path: Path, reported: list[str]) -> Leftovers:
    """Return the check of the processes of a folder."""
    return Leftovers(tmp_path, reported.append)


@pytest.fixture
def running(tmp_path: Path) -> Iterator[subprocess.Popen[bytes]]:
    """Return a process of the folder."""
    with start(tmp_path) as process:
        yield process
        process.communicate()


def test_processes_are_identified_by_their_folder(tmp_path: Path, running: subprocess.Popen[bytes]) -> None:
    home = tmp_path / MACHINES / "m2" / "t"
    home.mkdir(parents=True)
    with start(home, WAIT, "engine.fabric.router") as router, start(tmp_path.parent) as other:
        found = {member.process.pid: (member.kind, member.home) for member in cloud_processes(tmp_path)}
        assert found == {running.pid: ("other", OWN), router.pid: ("router", "m2")}
        for process in (router, other):
            process.communicate()


def test_a_standby_is_no_master_until_it_leads(tmp_path: Path) -> None:
    arguments = "robots.cli", "up", "--standby"

    def kinds() -> list[str]:
        return [member.kind for member in cloud_processes(tmp_path)]

    with start(tmp_path, WAIT, *arguments) as process:
        assert kinds() == [STANDBY]
        (tmp_path / "ready.json").write_text('{"url":"","pid":1,"admin_user":"admin"}')
        assert kinds() == [STANDBY], "an earlier process wrote the file"
        (tmp_path / "ready.json").write_text(f'{{"url":"","pid":{process.pid},"admin_user":"admin"}}')
        assert kinds() == ["master"]
        process.communicate()
    with start(tmp_path, WAIT, *arguments[:2]) as process:
        assert kinds() == ["master"]
        process.communicate()


def test_without_leftovers_nothing_is_reported(
    traces: Leftovers, running: subprocess.Popen[bytes], reported: list[str]
) -> None:
    assert len(traces.look()) == 1
    running.communicate()
    traces.at_end()
    assert reported == []


def test_a_leftover_process_and_file_are_reported(
    traces: Leftovers, tmp_path: Path, running: subprocess.Popen[bytes], reported: list[str]
) -> None:
    (tmp_path / "pymp-1").mkdir()
    (tmp_path / "log").write_text("not a leftover")
    traces.at_end()
    assert reported == [f"process {running.pid} (other of {OWN}) is left", f"{tmp_path / 'pymp-1'} is left"]


def test_leftover_shared_memory_is_reported(traces: Leftovers, tmp_path: Path, reported: list[str]) -> None:
    shared = Path("/dev/shm") / f"chaos-test-{os.getpid()}"
    code = "import mmap, sys; f = open(sys.argv[1], 'w+b'); f.truncate(99); m = mmap.mmap(f.fileno(), 99)\n"
    code += "print(1, flush=True); sys.stdin.read()"
    try:
        with start(tmp_path, code, str(shared)) as process:
            assert process.stdout is not None
            process.stdout.readline()
            traces.look()
            process.communicate()
        traces.at_end()
    finally:
        shared.unlink()
    assert reported == [f"{shared} is left"]


def test_a_zombie_that_is_not_reaped_is_reported(tmp_path: Path, reported: list[str]) -> None:
    clock = ManualClock()
    traces = Leftovers(tmp_path, reported.append, clock)
    code = "import subprocess, sys; c = subprocess.Popen([sys.executable, '-c', 'input()'], stdin=subprocess.PIPE)\n"
    code += "print(c.pid, flush=True); sys.stdin.readline(); c.stdin.close(); import os; "
    code += "os.waitid(os.P_PID, c.pid, os.WEXITED | os.WNOWAIT); print(1, flush=True); sys.stdin.read()"
    with start(tmp_path, code) as parent:
        assert parent.stdin is not None and parent.stdout is not None
        child = int(parent.stdout.readline())
        assert len(traces.look()) == 2
        parent.stdin.write(b"\n")
        parent.stdin.flush()
        parent.stdout.readline()
        traces.look()
        assert reported == []
        clock.advance(ZOMBIE_GRACE + 1.0)
        traces.look()
        parent.communicate()
    assert reported == [f"process {child} (other) has been a zombie for {ZOMBIE_GRACE + 1.0:.0f} s"]
