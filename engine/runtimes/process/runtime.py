"""Default runtime: each container is a process, forked from a warm fork server within milliseconds."""

import asyncio
import logging
from asyncio import Task

from engine.processes.background import Background
from engine.processes.child_process import OrphanReaper, adopt_orphans
from engine.runtimes.base import Premises, Runtime
from engine.runtimes.entries import Entry
from engine.runtimes.fork_server import early_start
from engine.runtimes.fork_server.child import run
from engine.runtimes.fork_server.server import ForkServer
from engine.runtimes.process.container import ForkedContainer
from engine.runtimes.process.control_groups import ControlGroups, own_hierarchies
from engine.specs.containers import Launch
from ppaas.errors import Unavailable

logger = logging.getLogger(__name__)


class ProcessRuntime(Runtime):
    """Forks containers from a warm fork server.

    Parameters
    ----------
    entry : Entry
        Function that takes the ``Launch`` in the new process and returns the exit status, with the modules that the
        fork server imports first.
    groups : ControlGroups, optional
        Groups that limit containers to their sizes. Without it, containers are only bound to their CPUs.
    """

    def __init__(self, entry: Entry, groups: ControlGroups | None = None) -> None:
        self._entry = entry
        self._groups = groups or ControlGroups("", ())
        self._server = ForkServer(entry)
        self._forking = asyncio.Lock()
        self._tasks: set[Task[ForkedContainer] | Task[None]] = set()
        self._live: set[ForkedContainer] = set()
        self._background = Background()
        self._closed = False

    @classmethod
    def on(cls, premises: Premises) -> "ProcessRuntime":
        """Return the runtime of a machine."""
        return cls(premises.entries.container, ControlGroups(premises.instance, own_hierarchies()))

    async def start(self) -> None:
        """Start the fork server and wait until it is warm. Call this before any other library starts threads.

        Raises
        ------
        Unavailable
            The fork server cannot import the modules of containers.
        """
        adopt_orphans(True)  # of a fork server or a compiler that is killed
        self._background.run(OrphanReaper(self._reaped_elsewhere).run())
        async with self._forking:
            await self._warm()

    async def launch(self, launch: Launch) -> ForkedContainer:
        """Fork a container.

        Raises
        ------
        Unavailable
            The fork server cannot be started, or died twice.
        """
        forking = asyncio.create_task(self._fork(launch))
        self._tasks.add(forking)
        forking.add_done_callback(self._tasks.discard)
        try:
            return await asyncio.shield(forking)
        except asyncio.CancelledError:
            forking.add_done_callback(_kill_result)
            raise

    async def close(self) -> None:
        """Kill all containers, wait until they have exited, and stop watching the fork server.

        The fork server itself ends with this process.
        """
        self._closed = True
        await asyncio.gather(*self._tasks, return_exceptions=True)
        live = tuple(self._live)
        for container in live:
            container.kill()
        await asyncio.gather(*(container.wait() for container in live))
        await self._groups.close()
        self._server.close()
        adopt_orphans(False)
        await self._background.cancel()

    def _reaped_elsewhere(self) -> set[int]:
        return {container.pid for container in self._live} | set(early_start.server())

    async def _fork(self, launch: Launch) -> ForkedContainer:
        async with self._forking:
            for _ in range(2):
                await self._warm()
                try:
                    process = await self._server.fork(run, self._entry.function, launch)
                except (EOFError, OSError) as error:
                    logger.warning("the fork server failed to start container %r: %s", launch.spec.id, error)
                    await self._server.end()
                    continue
                container = ForkedContainer(process, self._live.discard, launch, self._groups)
                self._live.add(container)
                return container
        raise Unavailable(f"container {launch.spec.id!r} could not be started: the fork server died twice")

    async def _warm(self) -> None:
        if self._closed:
            raise Unavailable("this runtime is closed")
        if not self._server.is_warm:
            report = await self._server.warm(self._on_server_death)
            logger.info("fork server %d is warm: %s threads, %d kernel modules", *report[:2], len(report.kernels))

    def _on_server_death(self) -> None:
        logger.error("the fork server died; its %d containers are lost", len(self._live))
        self._server.forget()
        rewarming = asyncio.create_task(self._warm_again())
        self._tasks.add(rewarming)
        rewarming.add_done_callback(self._tasks.discard)

    async def _warm_again(self) -> None:
        async with self._forking:
            try:
                await self._warm()
            except Unavailable:
                logger.exception("a new fork server could not be started; the next launch tries again")


def _kill_result(forking: Task[ForkedContainer]) -> None:
    if not forking.cancelled() and forking.exception() is None:
        forking.result().kill()
