"""One container of the Docker Engine: first a spare, then the container of a launch.

A size is a hard limit here, not a share: a container of 0.5 cores gets half of a CPU's time, even if the other half is
idle (``--cpus``, ``--cpuset-cpus``, ``--memory``). Spares, which only import modules, may use all CPUs at low weight.
"""

import asyncio
import contextlib
import logging
import math
import os
import shutil
import socket
import struct
from collections.abc import Callable, Coroutine
from pathlib import Path
from typing import Any

import msgspec

from engine.protocols.address import RELAY
from engine.runtimes.docker.engine import DockerEngine
from engine.runtimes.docker.entry import FOLDER, LAYERS, LINK, MACHINE, START
from engine.runtimes.memory_limits import memory_of
from engine.specs.containers import Launch
from engine.specs.cores import memory_limit
from ppaas.errors import Unavailable

logger = logging.getLogger(__name__)


# -- limits ------------------------------------------------------------------------------------------------------------

PERIOD = 100_000
"""Period of the CPU quota [µs]."""

LEAST_QUOTA = 1_000
"""Smallest quota that the kernel accepts [µs]."""

SHARES = 1024
"""CPU weight of a container of one core, which counts when the CPUs are overloaded."""

SPARE_SHARES = 64
"""CPU weight of a spare."""

PROCESSES = 128
"""Most processes and threads of a container."""


def spare_limits() -> dict[str, Any]:
    """Return the limits of a spare, as options of ``docker run``."""
    return {"cpu_shares": SPARE_SHARES, "pids_limit": PROCESSES, **_memory(memory_limit(0.0, 0))}


def launch_limits(launch: Launch) -> dict[str, Any]:
    """Return the limits of a launched container, as options of ``docker update``."""
    return {**cpu_limits(launch), **_memory(memory_of(launch))}


def cpu_limits(launch: Launch) -> dict[str, Any]:
    """Return only the CPU limits of a launched container."""
    size = launch.spec.cores
    return {
        "cpu_period": PERIOD,
        "cpu_quota": max(LEAST_QUOTA, math.ceil(size * PERIOD)),
        "cpu_shares": max(2, math.ceil(size * SHARES)),
        "cpuset_cpus": ",".join(map(str, launch.cpus)),
    }


def _memory(limit: int) -> dict[str, int]:
    return {"mem_limit": limit, "memswap_limit": limit}


# -- container ---------------------------------------------------------------------------------------------------------

_CREDENTIALS = struct.Struct("3i")
"""Process, user and group id of a peer (``SO_PEERCRED`` in unix(7))."""

Spawn = Callable[[Coroutine[Any, Any, None]], None]


class ContainerFolders:
    """The two folders of a container: the sockets that it may dial, and the layers of its map.

    They contain hard links. Nothing is copied, and the container sees nothing else of the machine.

    Parameters
    ----------
    sockets, layers : Path
        The folders, which are created.
    """

    def __init__(self, sockets: Path, layers: Path) -> None:
        self.sockets = sockets
        self.layers = layers
        self._endpoint = ""
        layers.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        for folder in (sockets, layers):
            folder.mkdir()
            folder.chmod(0o755)  # any user may enter where it is mounted; outside, its parent folder is private

    def link(self, launch: Launch) -> Launch:
        """Link the files of a launch; return the launch with the paths as the container sees them."""
        self._endpoint = launch.link
        link, machine = _shown(launch.link, self.sockets, LINK), _shown(launch.machine, self.sockets, MACHINE)
        seen = {"link": link, "machine": machine}
        relay = Path(launch.machine).parent / RELAY
        if relay.exists():
            _shown(str(relay), self.sockets, RELAY)
        if launch.layers:
            self.link_layers(Path(launch.layers))
            seen["layers"] = LAYERS
        return msgspec.structs.replace(launch, **seen)

    def link_layers(self, layers: Path) -> None:
        """Link the files of a folder of layers that are not linked yet."""
        for file in layers.iterdir():
            if not file.name.startswith("."):
                with contextlib.suppress(FileExistsError):
                    file.chmod(0o644)  # the container runs as another user; on this machine its folder is private
                    os.link(file, self.layers / file.name)

    def link_endpoint(self) -> None:
        """Link the current socket of the endpoint: the old link leads to the one that was replaced.

        Raises
        ------
        OSError
            The socket does not exist, or no longer.
        """
        (self.sockets / LINK).unlink(missing_ok=True)
        _shown(self._endpoint, self.sockets, LINK)

    def remove(self) -> None:
        """Remove both folders."""
        for folder in (self.sockets, self.layers):
            shutil.rmtree(folder, ignore_errors=True)


def _shown(path: str, folder: Path, name: str) -> str:
    if not path:
        return path
    Path(path).chmod(0o666)  # the container runs as another user; on this machine its folder is private
    os.link(path, folder / name)
    return f"{FOLDER}/{name}"


class DockerContainer:
    """A container from its start as a spare to its end.

    Parameters
    ----------
    engine : DockerEngine
        Engine that runs it.
    folders : ContainerFolders
        Its folders.
    spawn : callable
        Runs a coroutine in the background.
    started : callable
        Called with this object as soon as it has an id.
    """

    def __init__(
        self,
        engine: DockerEngine,
        folders: ContainerFolders,
        spawn: Spawn,
        started: Callable[["DockerContainer"], None],
    ) -> None:
        self._engine = engine
        self._folders = folders
        self._spawn = spawn
        self._started = started
        loop = asyncio.get_running_loop()
        self._dialled: asyncio.Future[asyncio.StreamWriter] = loop.create_future()
        self._status: asyncio.Future[int] = loop.create_future()
        self._last_log: asyncio.Future[str] = loop.create_future()
        self._server: asyncio.Server | None = None
        self._launched = False
        self._sizing = asyncio.Lock()
        self._layers: Path | None = None
        self.id = ""
        self.pid = 0

    @property
    def has_ended(self) -> bool:
        """Whether it has exited."""
        return self._status.done()

    async def start(self, command: list[str], limits: dict[str, Any]) -> None:
        """Start it, and wait until it is warm.

        Raises
        ------
        Unavailable
            The engine refuses, or the container exited before it was warm.
        """
        path = self._folders.sockets / START
        self._server = await asyncio.start_unix_server(self._on_dialled, path)
        # The process inside is no user of this host: anybody may dial, in a folder that is closed to other users.
        path.chmod(0o666)
        places = {FOLDER: self._folders.sockets, LAYERS: self._folders.layers}
        self.id = await self._engine.run(command, places, limits)
        self._started(self)
        await asyncio.wait((self._dialled, self._status), return_when=asyncio.FIRST_COMPLETED)
        if not self._dialled.done():
            status, log = self._status.result(), await self._last_log
            raise Unavailable(
                f"a container ended with status {status} before it was ready: {log or 'its log is empty'}"
            )

    def _on_dialled(self, _: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        if self._dialled.done():
            writer.close()  # only the first connection counts: later ones may come from a third-party plug-in
            return
        peer: socket.socket = writer.get_extra_info("socket")
        credentials = peer.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _CREDENTIALS.size)
        self.pid = _CREDENTIALS.unpack(credentials)[0]
        self._dialled.set_result(writer)

    async def assign(self, launch: Launch) -> None:
        """Hand a launch to this spare, and limit it to its size.

        Raises
        ------
        Unavailable
            It has exited, or the engine refuses its size.
        """
        await self._engine.limit(self.id, launch_limits(launch))
        try:
            seen = self._folders.link(launch)
        except OSError as error:
            raise Unavailable(
                f"container {launch.spec.id!r} cannot be given its sockets and map layers: {error}"
            ) from error
        self._layers = Path(launch.layers) if launch.layers else None
        self._launched = True
        writer = self._dialled.result()
        writer.write(msgspec.json.encode(seen) + b"\n")

    def layers_grew(self) -> None:
        """Link files that were added to the layers of its map since."""
        if self._layers is not None and not self.has_ended:
            self._folders.link_layers(self._layers)

    def endpoint_came(self) -> None:
        """Link the current socket of its endpoint, which the container dials repeatedly."""
        if not self._launched or self.has_ended:
            return
        try:
            self._folders.link_endpoint()
        except OSError as error:
            logger.warning("container %s cannot reach its endpoint: %s", self.id[:12], error)

    def resize(self, launch: Launch) -> None:
        """Limit it to another size from now on. Does nothing if it has exited.

        The engine takes no memory away that is in use. In that case only the CPU limits change.
        """
        if not self.has_ended:
            self._spawn(self._hold_to_size(launch))

    async def _hold_to_size(self, launch: Launch) -> None:
        async with self._sizing:  # the engine may execute two calls in any order, but the last size must win
            try:
                await self._engine.limit(self.id, launch_limits(launch))
            except Unavailable as error:
                if self.has_ended:
                    return
                logger.warning("container %s keeps its old memory limit: %s", launch.spec.id, error)
                await self._engine.limit(self.id, cpu_limits(launch))

    def kill(self) -> None:
        """Kill it. Does nothing if it has exited."""
        if not self.has_ended:
            self._spawn(self._engine.kill(self.id))

    async def wait(self) -> int:
        """Wait until it exits; return its exit status, negative for the signal that killed it."""
        return await asyncio.shield(self._status)

    def end(self, status: int) -> None:
        """Record its exit status; the engine has reported its end."""
        if self.has_ended:
            return
        self._status.set_result(status)
        self._spawn(self._clean_up(status))

    async def _clean_up(self, status: int) -> None:
        self.release()
        log = await self._engine.remove(self.id)
        self._last_log.set_result(log)
        if status > 0 and log:
            logger.warning("container %s ended with status %d; its last log lines:", self.id[:12], status)
            for line in log.splitlines():
                logger.warning("container %s: %s", self.id[:12], line)

    def release(self) -> None:
        """Close its connection, which ends it, and remove its folders."""
        if self._dialled.done() and not self._dialled.cancelled():
            self._dialled.result().close()
        if self._server is not None:
            self._server.close()
        self._folders.remove()
