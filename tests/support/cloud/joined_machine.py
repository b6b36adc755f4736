"""Child process ``ppaas machine join``."""

import asyncio
import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import psutil

from robots import cli
from robots.client.rest import RestClient
from tests.support.cloud.cloud import shared_memory
from tests.support.waiting import patience

PATIENCE = 60.0


def ticket(data: Path, *arguments: str) -> str:
    """Return a ticket of the cloud with the given data folder."""
    command = [sys.executable, "-m", cli.__name__, "machine", "ticket", "--data", str(data), *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


class JoinedMachine:
    """Process that a cloud sees as a machine of another host.

    Parameters
    ----------
    folder : Path
        Folder for its data and its log.
    name : str
        Name of the machine.
    within : tuple of str
        Command prefix, such as one that enters a network namespace.
    """

    def __init__(self, folder: Path, name: str, within: tuple[str, ...] = ()) -> None:
        self.name = name
        self._within = within
        self.log = folder / "log"
        self._data = folder / "data"
        self._runs = Path(tempfile.mkdtemp(prefix="m-"))  # elsewhere, because sockets need a short path
        self._family: list[psutil.Process] = []
        folder.mkdir()

    def start(self, *arguments: str) -> None:
        """Start the process; the first start needs a ticket."""
        command = [*self._within, sys.executable, "-m", cli.__name__, "machine", "join", *arguments]
        with self.log.open("ab") as output:
            self.process = subprocess.Popen(
                [*command, "--name", self.name, "--data", str(self._data)],
                stdout=output,
                stderr=output,
                env=os.environ | {"TMPDIR": str(self._runs)},
            )

    async def is_in(self, rest: RestClient) -> None:
        """Wait until the machine has joined the cloud; one that still starts is listed before."""
        async with patience(PATIENCE):
            while self.name not in await joined_machines(rest):
                assert self.process.poll() is None, self.log.read_text()
                await asyncio.sleep(0.05)
        self._family = psutil.Process(self.process.pid).children(recursive=True)

    def signal(self, number: int) -> None:
        """Send a signal; all its current descendants must exit with it."""
        self._family = psutil.Process(self.process.pid).children(recursive=True)
        self.process.send_signal(number)

    async def has_ended(self) -> int:
        """Wait until it and its descendants have exited; return its exit status."""
        return await asyncio.to_thread(self._ended)

    def _ended(self) -> int:
        status = self.process.wait(PATIENCE)
        _, alive = psutil.wait_procs(self._family, PATIENCE)
        assert not alive, f"left behind: {alive}\n{self.log.read_text()}"
        return status

    def end(self) -> None:
        """Stop it with SIGTERM; check that no run left anything behind."""
        self.signal(signal.SIGTERM)
        assert self._ended() == 0, self.log.read_text()
        assert not shared_memory(self.process.pid)
        self._runs.rmdir()  # fails unless it is empty


async def machines(rest: RestClient) -> list[str]:
    """Return the names of the machines of a cloud."""
    return [machine["id"] for machine in await rest.items("/v1/machines")]


async def joined_machines(rest: RestClient) -> list[str]:
    """Return the names of the machines of a cloud that have joined, without those that still start."""
    return [machine["id"] for machine in await rest.items("/v1/machines") if machine["state"] != "starting"]


async def container_of(rest: RestClient, robot: str) -> dict[str, Any]:
    """Return the container of a connected robot."""
    (found,) = [container for container in await rest.items("/v1/containers") if container["robot"] == robot]
    return dict(found)
