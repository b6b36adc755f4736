"""Programs that exit with their parent, and print answers alone."""

import signal
import subprocess
import sys
from pathlib import Path

from tests.support.engine.processes import has_ended
from tests.support.waiting import until

PROGRAM = """
import os
from engine.processes.helper_program import take_standard_output
answers = take_standard_output()
print("printed", flush=True)
os.system("echo by a child")
answers.write(b"an answer")
answers.flush()
"""


def test_answers_alone_are_on_standard_output() -> None:
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True)
    assert done.stdout == "an answer"
    assert done.stderr == "printed\nby a child\n"


CHILD = (
    "import time; from engine.processes.helper_program import end_with; "
    "end_with({parent}); print('there', flush=True); time.sleep(600)"
)


def start(file: Path, parent: str) -> "subprocess.Popen[str]":
    """Start a process with a child that must exit with it, and prints the child's process id."""
    script = (
        "import os, subprocess, sys, time\n"
        f"code = {CHILD!r}.format(parent={parent})\n"
        "child = subprocess.Popen([sys.executable, '-c', code], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)\n"
        "there = child.stdout.readline()\n"
        f"open({str(file)!r}, 'w').write(f'{{child.pid}}')\n"
        "print(child.wait() if not there else 'there', flush=True)\n"
        "time.sleep(600)\n"
    )
    return subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True)


async def test_child_exits_when_its_parent_is_killed(tmp_path: Path) -> None:
    with start(tmp_path / "child", "os.getpid()") as parent:
        assert parent.stdout is not None and parent.stdout.readline() == "there\n"
        child = int((tmp_path / "child").read_text())
        assert not has_ended(child)
        parent.send_signal(signal.SIGKILL)
    await until(lambda: has_ended(child))


def test_child_exits_at_once_if_its_parent_has_exited(tmp_path: Path) -> None:
    with start(tmp_path / "child", "1") as parent:
        assert parent.stdout is not None and parent.stdout.readline() == "1\n"
        parent.kill()
