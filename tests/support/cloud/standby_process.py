"""Child process ``ppaas up --standby``."""

import asyncio
import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import psutil

from endpoints.cloud_processes import serving
from robots import cli
from tests.support.cloud.cloud import ADMIN_PASSWORD, LOG_SHOWN, RunningCloud, named
from tests.support.waiting import until

STANDING_BY = "standing by"
"""Part of the line that a standby logs when it is ready to take over."""


class Standby:
    """A process that stands by, and may lead later.

    Parameters
    ----------
    folder : Path
        Folder for its data, its log and its ready file.
    arguments : str
        Further arguments; ``--standby`` is one of them.
    environment : mapping of str, optional
        Further environment variables.
    """

    def __init__(self, folder: Path, *arguments: str, environment: Mapping[str, str] | None = None) -> None:
        folder.mkdir(exist_ok=True)
        password, self._ready, self.log = folder / "password", folder / "ready.json", folder / "standby.log"
        password.write_text(ADMIN_PASSWORD)
        self._ready.unlink(missing_ok=True)
        command = [sys.executable, "-m", cli.__name__, "up", "--port", "0", "--data", str(folder / "data")]
        files = ["--admin-password-file", str(password), "--ready-file", str(self._ready)]
        with self.log.open("wb") as output:
            self.process = subprocess.Popen(
                [*command, *files, *arguments], stdout=output, stderr=output, env=os.environ | dict(environment or {})
            )

    async def stands_by(self) -> None:
        """Wait until it is ready to take over."""
        await until(lambda: self._is_running() and STANDING_BY in self.log.read_text(), 60.0)

    def endpoints(self) -> list[psutil.Process]:
        """Return its endpoint processes; they wait for their settings until it leads."""
        return named(psutil.Process(self.process.pid).children(), serving.__name__)

    async def leads(self) -> RunningCloud:
        """Wait until it leads and serves, and return it as a cloud."""
        await until(lambda: self._is_running() and self._ready.exists(), 60.0)
        found = json.loads(self._ready.read_text())
        return RunningCloud(found["url"], found["pid"], self.log)

    def _is_running(self) -> bool:
        assert self.process.poll() is None, self.log.read_text()
        return True

    async def has_ended(self) -> int:
        """Wait until it has ended by itself; return its exit status."""
        return await asyncio.to_thread(self.process.wait, 20.0)


@contextmanager
def standing_by(folder: Path, *arguments: str, environment: Mapping[str, str] | None = None) -> Iterator[Standby]:
    """Start a standby; stop it with SIGTERM unless it has ended, and check that it leaves no process behind."""
    standby = Standby(folder, *arguments, environment=environment)
    try:
        yield standby
    except BaseException:
        sys.stdout.write(standby.log.read_text()[-LOG_SHOWN:])  # shown with the failure
        raise
    finally:
        family = psutil.Process(standby.process.pid).children(recursive=True) if standby.process.poll() is None else []
        for number in (signal.SIGCONT, signal.SIGTERM):
            standby.process.send_signal(number)
        standby.process.wait(20.0)
        _, alive = psutil.wait_procs(family, 10.0)
        assert not alive, f"left behind: {alive}"
