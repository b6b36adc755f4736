"""Each container is one of the Docker engine: no network, no privileges, and nothing of the machine but its own.

A new interpreter takes a second until it can plan. So some containers are *spares*: they have loaded everything and
wait to be told what they are. The next one to be launched is told, gets its size, and another spare is started.
"""

import asyncio
import itertools
import logging
from collections import deque

from engine.processes.background import Background
from engine.runtimes.base import Premises, Runtime
from engine.runtimes.docker import entry as entry_module
from engine.runtimes.docker.container import Booth, DockerContainer
from engine.runtimes.docker.engine import DockerEngine
from engine.runtimes.docker.limits import of_spare
from engine.runtimes.entries import Entry
from engine.runtimes.fork_server.server import UNHEARD, ForkServer
from engine.runtimes.memory_tuning import lean_python
from engine.specs.containers import Launch
from ppaas.errors import Unavailable

logger = logging.getLogger(__name__)

SPARES = 2
"""Containers that wait to be told what they are; each takes some hundred megabytes."""

STARTING = 2
"""Spares that are started at a time: with more of them, the first is ready later."""

ATTEMPTS = 3

COMMAND = (*lean_python.PYTHON_OF_IMAGE, "-m", entry_module.__name__)


class DockerRuntime(Runtime):
    """Starts containers by the Docker engine of this computer.

    Parameters
    ----------
    premises : Premises
        The machine.
    entry : Entry, optional
        What of the image takes the ``Launch`` in a container, and what a spare loads before; the result is the exit
        status. Without it, that of the machine.
    spares : int
        How many wait.
    """

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
        """Return the runtime of a machine whose computer has a Docker engine."""
        return cls(premises)

    async def start(self) -> None:
        """Find engine and image, and wait until the first spare is warm; do it before other libraries start threads.

        Raises
        ------
        Unavailable
            There is no engine, no such image, or nothing can be run from it.
        """
        await self._connect()
        await self._maps.warm(self._maps.forget)  # layers of maps are made in processes of the machine itself
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
        """Tell a spare what it is.

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
                await container.become(launch)
            except BaseException as error:
                container.kill()
                if not (isinstance(error, Unavailable) and container.has_ended):
                    raise
            else:
                return container
        raise Unavailable(f"container {launch.spec.id!r} could not be started: its spares died {ATTEMPTS} times")

    async def close(self) -> None:
        """Remove all containers, and let go of the engine and of what was lent to them."""
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
        """Take a spare out, the warm ones first, and have another started."""
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
        booth = Booth(premises.run_dir / f"c-{number}", premises.shared_memory / f"seen-{number}")
        container = DockerContainer(self._engine, booth, self._background.run, self._started)
        try:
            async with self._starting:
                await container.start(self._command, of_spare())
        except BaseException:
            container.let_go()
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
            self._ended[container] = status  # before the engine had answered that it is started

    def _lost(self) -> None:
        """Give up what the engine had: whether it runs on, nobody tells, and what does is removed."""
        logger.error("the Docker engine ended; its %d containers are lost", len(self._live))
        self._connected = False
        lost, self._live = tuple(self._live.values()), {}
        for container in lost:
            container.end(UNHEARD)
