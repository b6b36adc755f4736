"""Child process ``ppaas up``, from its start to its exit."""

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
from tests.support.waiting import stretch

TIMEOUT = 60.0
"""Time limit of a start and of an end [s], on a computer that does nothing else."""


class Up:
    """Process ``ppaas up`` with its folders.

    Parameters
    ----------
    folder : Path
        Folder for its data, its log and its ready file.
    arguments : str
        Further arguments.
    """

    def __init__(self, folder: Path, *arguments: str) -> None:
        self.folder = folder
        self.log = folder / "log"
        self.runs = Path(tempfile.mkdtemp(prefix="up-"))  # elsewhere, because sockets need a short path
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
        """Wait until a condition holds while the process runs; stop the process before failing."""
        began = time.monotonic()
        while not condition():
            elapsed = time.monotonic() - began
            if self.process.poll() is not None or (elapsed > TIMEOUT and elapsed > TIMEOUT * stretch()):
                self.process.terminate()
                pytest.fail(
                    f"condition not met within {elapsed:.0f} s, or the process has exited:\n{self.log.read_text()}"
                )
            time.sleep(0.005)

    def children(self, word: str = "") -> list[psutil.Process]:
        """Return the descendants with a word in their command line."""
        return named(psutil.Process(self.process.pid).children(recursive=True), word)

    def end(self, number: int) -> int:
        """Send a signal; check that nothing is left behind, and return the exit status."""
        family = self.children()
        self.process.send_signal(number)
        status = self.wait()
        _, alive = psutil.wait_procs(family, 15 * stretch())
        assert not alive, f"left behind: {alive}\n{self.log.read_text()}"
        assert not any(shared_memory(child.pid) for child in family)
        return status

    def wait(self) -> int:
        """Wait for the exit, and return the exit status."""
        status = self.process.wait(TIMEOUT * stretch())
        self.runs.rmdir()  # fails unless it is empty
        return status
