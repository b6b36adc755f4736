"""Launches of test containers, and the socket on which they report."""

import asyncio
import itertools
from pathlib import Path
from typing import NamedTuple

from engine.specs.containers import ContainerSpec, Launch, MapVersion

_numbers = itertools.count(1)


class Report(NamedTuple):
    """Report of a container: its id, its process id, and a text."""

    container: str
    pid: int
    text: str


class Reports:
    """A socket that test containers dial.

    Parameters
    ----------
    folder : Path
        Folder of the socket.

    Attributes
    ----------
    hung_up : set of str
        Containers whose connection was closed after a report.
    """

    def __init__(self, folder: Path) -> None:
        self.path = str(folder / "reports.sock")
        self.hung_up: set[str] = set()
        self._queue: asyncio.Queue[Report] = asyncio.Queue()
        self._server: asyncio.Server | None = None

    async def __aenter__(self) -> "Reports":
        self._server = await asyncio.start_unix_server(self.connected, self.path)
        return self

    async def __aexit__(self, *_: object) -> None:
        assert self._server is not None
        self._server.close()

    async def connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, _: str = "") -> None:
        """Read the reports of a container, which may come through a machine of another host."""
        container = ""
        while line := (await reader.readline()).decode():
            container, pid, text = line.strip().split(" ", 2)
            self._queue.put_nowait(Report(container, int(pid), text))
        self.hung_up.add(container)
        writer.close()

    async def next(self, timeout: float = 30.0) -> Report:
        """Return the next report."""
        async with asyncio.timeout(timeout):
            return await self._queue.get()

    def launch(self, *, cpus: tuple[int, ...] = (0,), threads: int = 1, layers: str = "", secret: str = "") -> Launch:
        """Return a launch whose container reports here."""
        spec = ContainerSpec(f"c{next(_numbers)}", "ann", MapVersion("house", "v1"), float(len(cpus)))
        return Launch(spec, layers=layers, link=self.path, machine="", secret=secret, cpus=cpus, threads=threads)
