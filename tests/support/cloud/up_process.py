"""``ppaas up`` in a process of its own, from its first moment to its last."""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import psutil
import pytest

from robots import cli
from tests.support.cloud.cloud import named, shared_memory

TIMEOUT = 60.0


class Up:
    """The process, with all its folders below one.

    Parameters
    ----------
    folder : Path
        For its data, its log and what it makes while it runs.
    arguments : str
        More of its arguments.
    """

    def __init__(self, folder: Path, *arguments: str) -> None:
        self.folder = folder
        self.log = folder / "log"
        self.runs = Path(tempfile.mkdtemp(prefix="up-"))  # not below the folder: sockets need a short path
        self.ready = folder / "ready.json"
        command = [sys.executable, "-m", cli.__name__, "up", "--port", "0", "--data", str(folder / "data")]
        with self.log.open("wb") as output:
            self.process = subprocess.Popen(
                [*command, "--ready-file", str(self.ready), *arguments],
                stdout=output,
                stderr=output,
                env=os.environ | {"TMPDIR": str(self.runs)},
            )

    def wait_for(self, condition: Callable[[], object]) -> None:
        """Wait until a condition holds; the process must still run. A test that fails here leaves nothing running."""
        deadline = time.monotonic() + TIMEOUT
        while not condition():
            if self.process.poll() is not None or time.monotonic() >= deadline:
                self.process.terminate()
                pytest.fail(f"no sign of it within {TIMEOUT:.0f} s, or it has ended:\n{self.log.read_text()}")
            time.sleep(0.005)

    def children(self, word: str = "") -> list[psutil.Process]:
        """Return the processes below this one with a word in their command line."""
        return named(psutil.Process(self.process.pid).children(recursive=True), word)

    def end(self, number: int) -> int:
        """Send a signal; return the exit status, after a look at whether anything was left behind."""
        family = self.children()
        self.process.send_signal(number)
        status = self.wait()
        _, alive = psutil.wait_procs(family, 15)
        assert not alive, f"left behind: {alive}\n{self.log.read_text()}"
        assert not any(shared_memory(child.pid) for child in family)
        return status

    def wait(self) -> int:
        """Return the exit status, once it has ended by itself or by a signal."""
        status = self.process.wait(TIMEOUT)
        self.runs.rmdir()  # so it is empty
        return status
