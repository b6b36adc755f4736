"""Exclusive lock for the writer of a note."""

import subprocess
import sys

from engine.processes.disk_notes import exclusive


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
