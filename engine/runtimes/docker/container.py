"""One container of the Docker engine: first a spare, then what a launch says."""

import asyncio
import contextlib
import logging
import os
import shutil
import socket
import struct
from collections.abc import Callable, Coroutine
from pathlib import Path
from typing import Any

import msgspec

from engine.runtimes.docker.engine import DockerEngine
from engine.runtimes.docker.entry import FOLDER, LAYERS, LINK, MACHINE, START
from engine.runtimes.docker.limits import cpus_of_launch, of_launch
from engine.specs.containers import Launch
from ppaas.errors import Unavailable

logger = logging.getLogger(__name__)

_CREDENTIALS = struct.Struct("3i")
"""Process, user and group of a peer (``SO_PEERCRED`` in unix(7))."""

Spawn = Callable[[Coroutine[Any, Any, None]], None]


class Booth:
    """The two folders of a container: the sockets that it may dial, and the layers of its map.

    What lies in them are hard links: nothing is copied, and nothing else of the machine is seen.

    Parameters
    ----------
    sockets, layers : Path
        The folders, which are made.
    """

    def __init__(self, sockets: Path, layers: Path) -> None:
        self.sockets = sockets
        self.layers = layers
        self._endpoint = ""
        layers.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        for folder in (sockets, layers):
            folder.mkdir()
            folder.chmod(0o755)  # others may enter, where it is mounted: the folder that it is in lets nobody through

    def admit(self, launch: Launch) -> Launch:
        """Put in what a container is to see; return its launch as it sees it from inside."""
        self._endpoint = launch.link
        link, machine = _shown(launch.link, self.sockets, LINK), _shown(launch.machine, self.sockets, MACHINE)
        seen = {"link": link, "machine": machine}
        if launch.layers:
            self.link_layers(Path(launch.layers))
            seen["layers"] = LAYERS
        return msgspec.structs.replace(launch, **seen)

    def link_layers(self, layers: Path) -> None:
        """Put in what is in a folder of layers, and not here yet."""
        for file in layers.iterdir():
            if not file.name.startswith("."):
                with contextlib.suppress(FileExistsError):
                    os.link(file, self.layers / file.name)

    def link_endpoint(self) -> None:
        """Put in the socket that has the name of the endpoint's now: what is here leads to the one that had it before.

        Raises
        ------
        OSError
            There is none, or no longer.
        """
        (self.sockets / LINK).unlink(missing_ok=True)
        _shown(self._endpoint, self.sockets, LINK)

    def remove(self) -> None:
        """Remove both."""
        for folder in (self.sockets, self.layers):
            shutil.rmtree(folder, ignore_errors=True)


def _shown(path: str, folder: Path, name: str) -> str:
    if not path:
        return path
    Path(path).chmod(0o666)  # the container has another user; on this machine the folder that it is in is ours alone
    os.link(path, folder / name)
    return f"{FOLDER}/{name}"


class DockerContainer:
    """A container from its start as a spare to its end.

    Parameters
    ----------
    engine : DockerEngine
        That runs it.
    booth : Booth
        Its folders.
    spawn : callable
        Runs what nobody waits for.
    started : callable
        Told when it has its id.
    """

    def __init__(
        self, engine: DockerEngine, booth: Booth, spawn: Spawn, started: Callable[["DockerContainer"], None]
    ) -> None:
        self._engine = engine
        self._booth = booth
        self._spawn = spawn
        self._started = started
        loop = asyncio.get_running_loop()
        self._dialled: asyncio.Future[asyncio.StreamWriter] = loop.create_future()
        self._status: asyncio.Future[int] = loop.create_future()
        self._last_words: asyncio.Future[str] = loop.create_future()
        self._server: asyncio.Server | None = None
        self._launched = False
        self._sizing = asyncio.Lock()
        self._layers: Path | None = None
        self.id = ""
        self.pid = 0

    @property
    def has_ended(self) -> bool:
        """It is gone."""
        return self._status.done()

    async def start(self, command: list[str], limits: dict[str, Any]) -> None:
        """Start it, and wait until it is warm.

        Raises
        ------
        Unavailable
            The engine refuses, or it ended before it was warm.
        """
        path = self._booth.sockets / START
        self._server = await asyncio.start_unix_server(self._on_dialled, path)
        path.chmod(0o666)
        places = {FOLDER: self._booth.sockets, LAYERS: self._booth.layers}
        self.id = await self._engine.run(command, places, limits)
        self._started(self)
        await asyncio.wait((self._dialled, self._status), return_when=asyncio.FIRST_COMPLETED)
        if not self._dialled.done():
            status, said = self._status.result(), await self._last_words
            raise Unavailable(
                f"a container ended with status {status} before it was ready: {said or 'it said nothing'}"
            )

    def _on_dialled(self, _: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        if self._dialled.done():
            writer.close()  # once is enough: whoever runs in it now may be anybody's plug-in
            return
        peer: socket.socket = writer.get_extra_info("socket")
        credentials = peer.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _CREDENTIALS.size)
        self.pid = _CREDENTIALS.unpack(credentials)[0]
        self._dialled.set_result(writer)

    async def become(self, launch: Launch) -> None:
        """Tell it what it is, and hold it to its size.

        Raises
        ------
        Unavailable
            It has ended, or may not have so much.
        """
        await self._engine.limit(self.id, of_launch(launch))
        try:
            seen = self._booth.admit(launch)
        except OSError as error:
            raise Unavailable(f"container {launch.spec.id!r} cannot be shown what it needs: {error}") from error
        self._layers = Path(launch.layers) if launch.layers else None
        self._launched = True
        writer = self._dialled.result()
        writer.write(msgspec.json.encode(seen) + b"\n")

    def layers_grew(self) -> None:
        """Link what was put beside the layers of its map since."""
        if self._layers is not None and not self.has_ended:
            self._booth.link_layers(self._layers)

    def endpoint_came(self) -> None:
        """Link the socket that has its endpoint's name now, for it dials again and again."""
        if not self._launched or self.has_ended:
            return
        try:
            self._booth.link_endpoint()
        except OSError as error:
            logger.warning("container %s does not reach its endpoint: %s", self.id[:12], error)

    def resize(self, launch: Launch) -> None:
        """Hold it to another size from now on; nothing happens where it is gone.

        The engine takes no memory away that is in use: then its memory stays, and its CPUs alone are those of its size.
        """
        if not self.has_ended:
            self._spawn(self._hold_to_size(launch))

    async def _hold_to_size(self, launch: Launch) -> None:
        async with self._sizing:  # the engine may carry out two orders in any order, and the last one counts
            try:
                await self._engine.limit(self.id, of_launch(launch))
            except Unavailable as error:
                if self.has_ended:
                    return
                logger.warning("container %s keeps the memory that it had: %s", launch.spec.id, error)
                await self._engine.limit(self.id, cpus_of_launch(launch))

    def kill(self) -> None:
        """End it by force; nothing happens where it is gone."""
        if not self.has_ended:
            self._spawn(self._engine.kill(self.id))

    async def wait(self) -> int:
        """Return its exit status when it is gone, negative for the signal that killed it."""
        return await asyncio.shield(self._status)

    def end(self, status: int) -> None:
        """Take note that it is gone."""
        if self.has_ended:
            return
        self._status.set_result(status)
        self._spawn(self._bury(status))

    async def _bury(self, status: int) -> None:
        self.let_go()
        said = await self._engine.bury(self.id)
        self._last_words.set_result(said)
        if status > 0 and said:
            logger.warning("container %s ended with status %d; it said last:\n%s", self.id[:12], status, said)

    def let_go(self) -> None:
        """Hang up on it, which ends it, and remove its folders."""
        if self._dialled.done() and not self._dialled.cancelled():
            self._dialled.result().close()
        if self._server is not None:
            self._server.close()
        self._booth.remove()
