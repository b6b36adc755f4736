"""A folder has one owner: errors name it, and its exit frees the folder, also after SIGKILL; a note has one writer.

The kind is "one folder, one cloud". Its members: the data folder of a cloud, an SQLite store outside of it, and the
folder of a machine that joined a cloud. The files in a data folder (outbox, settings and records of machines) are of
its owner.
"""

import errno
import fcntl
import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from engine.processes.disk_notes import exclusive
from engine.processes.exclusive_owner import sole_owner
from ppaas.errors import InvalidInput, Unavailable

HOLD = """
import sys
from pathlib import Path
from engine.processes.exclusive_owner import sole_owner

with sole_owner(Path(sys.argv[1]), "the folder", "take another"):
    print("held", flush=True)
    sys.stdin.read()
"""


def hold(lock: Path) -> "subprocess.Popen[str]":
    command = [sys.executable, "-c", HOLD, str(lock)]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "held\n"
    return process


def test_a_second_owner_is_refused_and_told_who_the_first_is_and_since_when(tmp_path: Path) -> None:
    first = hold(tmp_path / "lock")
    try:
        with (
            pytest.raises(Unavailable, match=rf"the folder is in use by process {first.pid} of host .* since 20\d\d-"),
            sole_owner(tmp_path / "lock", "the folder", "take another"),
        ):
            pass
    finally:
        first.kill()
        first.wait()


def test_a_killed_owner_leaves_the_lock_free(tmp_path: Path) -> None:
    first = hold(tmp_path / "lock")
    first.kill()
    first.wait()
    with sole_owner(tmp_path / "lock", "the folder", "take another"):
        pass


def test_a_process_that_the_owner_started_does_not_hold_the_lock(tmp_path: Path) -> None:
    with sole_owner(tmp_path / "lock", "the folder", "take another"):
        child = subprocess.Popen(["sleep", "60"], close_fds=False)
    try:
        with sole_owner(tmp_path / "lock", "the folder", "take another"):
            pass
    finally:
        child.kill()
        child.wait()


def test_an_owner_that_has_not_written_its_name_yet_is_called_another_process(tmp_path: Path) -> None:
    lock = tmp_path / "lock"
    handle = os.open(lock, os.O_CREAT | os.O_RDWR)
    fcntl.flock(handle, fcntl.LOCK_EX)
    with (
        pytest.raises(Unavailable, match="in use by another process: stop that process, or take another"),
        sole_owner(lock, "the folder", "take another"),
    ):
        pass
    os.close(handle)


def test_the_lock_file_is_private(tmp_path: Path) -> None:
    with sole_owner(tmp_path / "lock", "the folder", "take another"):
        assert stat.S_IMODE((tmp_path / "lock").stat().st_mode) == 0o600


def test_a_lock_file_that_cannot_be_created_is_reported(tmp_path: Path) -> None:
    with (
        pytest.raises(InvalidInput, match=r"cannot create .*: No such file or directory; take another"),
        sole_owner(tmp_path / "nowhere" / "lock", "the folder", "take another"),
    ):
        pass


def test_a_file_system_without_locks_is_a_warning(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def refuse(*_: object) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(fcntl, "flock", refuse)
    with sole_owner(tmp_path / "lock", "the folder", "take another"):
        assert "the folder cannot be locked (No locks available)" in caplog.text


def test_two_processes_do_not_hold_the_lock_at_once(tmp_path):
    lock, seen = tmp_path / "folder" / "a.lock", tmp_path / "seen"
    script = (
        "import sys, time; from pathlib import Path; from engine.processes.disk_notes import exclusive\n"
        "with exclusive(Path(sys.argv[1])):\n"
        "    seen = Path(sys.argv[2]); assert not seen.exists(); seen.touch(); time.sleep(0.2); seen.unlink()"
    )
    command = [sys.executable, "-c", script, str(lock), str(seen)]
    processes = [subprocess.Popen(command) for _ in range(3)]
    assert [process.wait(60) for process in processes] == [0, 0, 0]


def test_without_a_lock_file_no_process_waits(tmp_path):
    (tmp_path / "file").touch()
    with exclusive(tmp_path / "file" / "a.lock"):
        assert not (tmp_path / "file").is_dir()
