"""Docker runtime: containers of the Docker Engine, without network, without privileges, isolated from the machine.

A new interpreter takes a second until it can plan. So some containers are *spares*, which have imported everything and
wait for a launch. A launch goes to the next spare, which gets its size, and another spare is started.
"""

import asyncio
import itertools
import logging
from collections import deque

from engine.processes.background import Background
from engine.runtimes.base import Premises, Runtime
from engine.runtimes.docker import entry as entry_module
from engine.runtimes.docker.container import ContainerFolders, DockerContainer, spare_limits
from engine.runtimes.docker.engine import DockerEngine
from engine.runtimes.entries import Entry
from engine.runtimes.fork_server.server import UNKNOWN_STATUS, ForkServer
from engine.runtimes.memory_tuning import lean_python
from engine.specs.containers import Launch
from ppaas.errors import Unavailable

logger = logging.getLogger(__name__)

SPARES = 2
"""Number of spares; each takes a few hundred megabytes."""

STARTING = 2
"""Most spares that start at once: with more, the first is ready later."""

ATTEMPTS = 3

COMMAND = (*lean_python.PYTHON_OF_IMAGE, "-m", entry_module.__name__)


class DockerRuntime(Runtime):
    """Starts containers of the Docker Engine of this computer.

    Parameters
    ----------
    premises : Premises
        The machine.
    entry : Entry, optional
        Function of the image that takes the ``Launch`` in a container and returns the exit status, with the modules
        that a spare imports first. Default: the entry of the machine.
    spares : int
        Number of spares.
    """

    isolates = True

    def __init__(self, premises: Premises, entry: Entry | None = None, spares: int = SPARES) -> None:
        self._premises = premises
        function, preload, _ = entry or premises.entries.container
        self._command = [*COMMAND, *preload, function]
        self._wanted = spares
        self._engine = DockerEngine(premises.instance, premises.image)
        self._maps = ForkServer(premises.entries.maps)
        self._numbers = itertools.count(1)
        self._starting = asyncio.Semaphore(STARTING)
        self._spares: deque[asyncio.Task[DockerContainer]] = deque()
        self._live: dict[str, DockerContainer] = {}
        self._ended: dict[str, int] = {}
        self._background = Background()
        self._connecting = asyncio.Lock()
        self._connected = False
        self._closed = False

    @classmethod
    def on(cls, premises: Premises) -> "DockerRuntime":
        """Return the runtime of a machine."""
        return cls(premises)

    async def start(self) -> None:
        """Find engine and image, and wait until the first spare is warm.

        Call this before any other library starts threads.

        Raises
        ------
        Unavailable
            The engine does not answer, has no such image, or cannot run a container from it.
        """
        await self._connect()
        await self._maps.warm(self._maps.forget)  # layers of maps are built in processes on the machine itself
        for _ in range(self._wanted):
            self._order()
        if self._spares:
            await asyncio.shield(self._spares[0])

    async def _connect(self) -> None:
        async with self._connecting:
            if not self._connected:
                await self._engine.connect(self._died, self._lost)
                self._connected = True

    async def launch(self, launch: Launch) -> DockerContainer:
        """Hand a launch to a spare.

        Raises
        ------
        Unavailable
            The engine refuses, or no spare can be started.
        """
        for _ in range(ATTEMPTS):
            container = await self._next()
            if container.has_ended:
                continue
            try:
                await container.assign(launch)
            except BaseException as error:
                container.kill()
                if not (isinstance(error, Unavailable) and container.has_ended):
                    raise
            else:
                return container
        raise Unavailable(f"container {launch.spec.id!r} could not be started: its spares died {ATTEMPTS} times")

    async def close(self) -> None:
        """Remove all containers and their folders, and close the connection to the engine."""
        if self._closed:
            return
        self._closed = True
        for spare in self._spares:
            spare.cancel()
        await asyncio.gather(*self._spares, return_exceptions=True)
        await self._engine.close()
        for container in tuple(self._live.values()):
            container.end(-9)
        await self._background.join()
        self._maps.close()

    # -- spares --------------------------------------------------------------------------------------------------------

    def _order(self) -> None:
        self._spares.append(asyncio.create_task(self._start_spare()))

    async def _next(self) -> DockerContainer:
        """Take a spare, a warm one if there is one, and start another."""
        if self._closed:
            raise Unavailable("this runtime is closed")
        await self._connect()
        self._order()
        taken = next((spare for spare in self._spares if spare.done()), self._spares[0])
        self._spares.remove(taken)
        try:
            return await asyncio.shield(taken)
        except asyncio.CancelledError:
            self._spares.appendleft(taken)
            raise

    async def _start_spare(self) -> DockerContainer:
        number = next(self._numbers)
        premises = self._premises
        folders = ContainerFolders(premises.run_dir / f"c-{number}", premises.shared_memory / f"seen-{number}")
        container = DockerContainer(self._engine, folders, self._background.run, self._started)
        try:
            async with self._starting:
                await container.start(self._command, spare_limits())
        except BaseException:
            container.release()
            raise
        return container

    def _started(self, container: DockerContainer) -> None:
        if container.id in self._ended:
            container.end(self._ended.pop(container.id))
        else:
            self._live[container.id] = container

    def _died(self, container: str, status: int) -> None:
        if container in self._live:
            self._live.pop(container).end(status)
        else:
            self._ended[container] = status  # reported before the call that starts it has returned

    def _lost(self) -> None:
        """Give up all containers of the engine, since their state is unknown.

        Those that still run are removed at the next connection.
        """
        logger.error("the Docker Engine ended; its %d containers are lost", len(self._live))
        self._connected = False
        lost, self._live = tuple(self._live.values()), {}
        for container in lost:
            container.end(UNKNOWN_STATUS)
