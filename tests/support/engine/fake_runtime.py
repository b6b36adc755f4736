"""A runtime without processes: the test controls when a container starts and exits."""

import asyncio
import os

from engine.specs.containers import Launch
from ppaas.errors import PPaaSError


class FakeProcess:
    """A process that exits when it is killed, or when the test calls ``end``."""

    def __init__(self, launch: Launch) -> None:
        self.launch = launch
        self.pid = os.getpid()
        self.killed = False
        self.told_of_layers = self.told_of_endpoints = 0
        self._status: asyncio.Future[int] = asyncio.get_running_loop().create_future()

    def kill(self) -> None:
        self.killed = True
        self.end(-9)

    def end(self, status: int) -> None:
        if not self._status.done():
            self._status.set_result(status)

    def layers_grew(self) -> None:
        self.told_of_layers += 1

    def endpoint_came(self) -> None:
        self.told_of_endpoints += 1

    def resize(self, launch: Launch) -> None:
        self.launch = launch

    async def wait(self) -> int:
        return await asyncio.shield(self._status)


class FakeRuntime:
    """Launches while ``go`` is set, and raises ``error`` if it is set."""

    isolates = False

    def __init__(self) -> None:
        self.launches: list[Launch] = []
        self.processes: dict[str, FakeProcess] = {}
        self.error: PPaaSError | Exception | None = None
        self.go = asyncio.Event()
        self.go.set()
        self.closed = False

    async def start(self) -> None:
        pass

    async def launch(self, launch: Launch) -> FakeProcess:
        self.launches.append(launch)
        await self.go.wait()
        assert not self.closed
        if self.error is not None:
            raise self.error
        process = self.processes[launch.spec.id] = FakeProcess(launch)
        return process

    async def close(self) -> None:
        self.closed = True
        for process in self.processes.values():
            process.kill()
