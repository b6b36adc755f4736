"""``ppaas machine join`` in a process of its own."""

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

PATIENCE = 60.0


def ticket(data: Path, *arguments: str) -> str:
    """Return a ticket of the cloud with a data folder."""
    command = [sys.executable, "-m", cli.__name__, "machine", "ticket", "--data", str(data), *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


class JoinedMachine:
    """A machine of another host, as far as a cloud can tell.

    Parameters
    ----------
    folder : Path
        For its data and its log.
    name : str
        Of the machine.
    within : tuple of str
        Words before its command, which run it somewhere else.
    """

    def __init__(self, folder: Path, name: str, within: tuple[str, ...] = ()) -> None:
        self.name = name
        self._within = within
        self.log = folder / "log"
        self._data = folder / "data"
        self._runs = Path(tempfile.mkdtemp(prefix="m-"))  # not below the folder: sockets need a short path
        self._family: list[psutil.Process] = []
        folder.mkdir()

    def start(self, *arguments: str) -> None:
        """Start it, for the first time with a ticket."""
        command = [*self._within, sys.executable, "-m", cli.__name__, "machine", "join", *arguments]
        with self.log.open("ab") as output:
            self.process = subprocess.Popen(
                [*command, "--name", self.name, "--data", str(self._data)],
                stdout=output,
                stderr=output,
                env=os.environ | {"TMPDIR": str(self._runs)},
            )

    async def is_in(self, rest: RestClient) -> None:
        """Wait until the cloud has it."""
        async with asyncio.timeout(PATIENCE):
            while self.name not in await machines(rest):
                assert self.process.poll() is None, self.log.read_text()
                await asyncio.sleep(0.05)
        self._family = psutil.Process(self.process.pid).children(recursive=True)

    def signal(self, number: int) -> None:
        """Send it a signal; what it has started by then must end with it."""
        self._family = psutil.Process(self.process.pid).children(recursive=True)
        self.process.send_signal(number)

    async def has_ended(self) -> int:
        """Wait until it and all that it started is gone; return its exit status."""
        return await asyncio.to_thread(self._ended)

    def _ended(self) -> int:
        status = self.process.wait(PATIENCE)
        _, alive = psutil.wait_procs(self._family, PATIENCE)
        assert not alive, f"left behind: {alive}\n{self.log.read_text()}"
        return status

    def end(self) -> None:
        """End it in order, and see that it leaves nothing behind, nor did the lives before."""
        self.signal(signal.SIGTERM)
        assert self._ended() == 0, self.log.read_text()
        assert not shared_memory(self.process.pid)
        self._runs.rmdir()  # so it is empty


async def machines(rest: RestClient) -> list[str]:
    """Return the names of the machines of a cloud."""
    return [machine["id"] for machine in await rest.items("/v1/machines")]


async def container_of(rest: RestClient, robot: str) -> dict[str, Any]:
    """Return the container of a robot that is connected."""
    (found,) = [container for container in await rest.items("/v1/containers") if container["robot"] == robot]
    return dict(found)
