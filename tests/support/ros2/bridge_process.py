"""Child process ``ppaas bridge ros2``."""

import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

from robots import cli
from tests.support.waiting import PATIENCE

STARTED = "types of messages"
"""Words that the bridge logs when it has joined the graph."""


COMMAND = (sys.executable, "-m", cli.__name__, "bridge", "ros2")


@contextmanager
def bridge_process(
    *arguments: str, log: Path, command: Sequence[str | Path] = COMMAND, env: Mapping[str, str] | None = None
) -> Iterator[subprocess.Popen[bytes]]:
    """Run ``ppaas bridge ros2``; print its log at the end, which pytest shows of a failed test."""
    with log.open("wb") as output:
        process = subprocess.Popen([*command, *arguments], stdout=output, stderr=output, env=env)
    try:
        deadline = time.monotonic() + PATIENCE
        while STARTED not in log.read_text():
            assert process.poll() is None and time.monotonic() < deadline, log.read_text()
            time.sleep(0.05)
        yield process
    finally:
        process.terminate()
        process.wait(20)
        sys.stdout.write(log.read_text())
