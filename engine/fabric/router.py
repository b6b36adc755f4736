"""The Zenoh router of a machine, as a process that can be restarted by itself.

``python -m engine.fabric.router`` reads its settings as JSON from standard input and writes one line when it listens.
From then on it echoes each byte that it reads, which shows that it is not frozen. It exits at the end of standard
input, which also happens when its parent exits. Clients need a name and password of the credentials file. Scouting is
off.
"""

import asyncio
import contextlib
import logging
import os
import secrets
import sys
from asyncio.subprocess import PIPE, Process
from pathlib import Path

import msgspec
import zenoh

from engine.fabric.zenoh_config import Peering, RouterCredentials, router_config
from engine.processes.child_process import end
from engine.processes.heartbeats import BEAT_PERIOD, MISSED, Heartbeats
from engine.processes.private_files import write_private
from ppaas.decoding import from_json
from ppaas.errors import Unavailable

logger = logging.getLogger(__name__)

READY = b"ready\n"
START_TIMEOUT = 10.0
STEADY = 5.0
"""Uptime after which a router that exits is restarted without delay [s]."""

ANSWER_GRACE = 0.1
"""Additional wait for a late echo [s]."""

RETRY = 0.2
"""Delay before the restart of a router that exited earlier [s]."""

STOP_GRACE = 2.0
"""Time for a router to exit [s]."""


class RouterSettings(msgspec.Struct, frozen=True):
    """Addresses and credentials of a router.

    Parameters
    ----------
    listen : tuple of str
        Zenoh endpoints: ``unixsock-stream//run/ppaas/router.sock``, ``tcp/127.0.0.1:7447``.
    credentials : str
        File with a line ``name:password`` for each client.
    own : RouterCredentials
        Credentials of this router for other routers.
    peering : Peering, optional
        Connection to the routers of other hosts.
    """

    listen: tuple[str, ...]
    credentials: str
    own: RouterCredentials
    peering: Peering | None = None


def serve(settings: RouterSettings) -> None:
    """Run a router until the end of standard input."""
    zenoh.init_log_from_env_or("error")
    with zenoh.open(router_config(settings.listen, settings.credentials, settings.own, settings.peering)):
        os.write(sys.stdout.fileno(), READY)
        while beats := os.read(sys.stdin.fileno(), 4096):
            os.write(sys.stdout.fileno(), beats)


class RouterProcess:
    """Keeps the router of a machine running.

    Parameters
    ----------
    folder : Path
        Folder of its socket and credentials; created with mode 700 if it does not exist.
    tcp : str, optional
        Additional address, ``host:port``, for clients that cannot reach the socket.
    peering : Peering, optional
        Connection to the routers of other hosts.
    """

    def __init__(self, folder: Path, *, tcp: str | None = None, peering: Peering | None = None) -> None:
        self._folder = folder
        self._peering = peering
        self.endpoint = f"unixsock-stream/{folder / 'router.sock'}"
        self.credentials = peering.credentials if peering else RouterCredentials("agent", secrets.token_urlsafe(32))
        self._listen = (self.endpoint, f"tcp/{tcp}") if tcp else (self.endpoint,)
        self._process: Process | None = None
        self._keeper: asyncio.Task[None] | None = None
        self.restarts = 0

    @property
    def pid(self) -> int | None:
        """Process id of the running router."""
        return self._process.pid if self._process is not None else None

    async def start(self) -> None:
        """Start the router, wait until it listens, and restart it whenever it exits.

        Raises
        ------
        Unavailable
            It exited before it listened.
        """
        self._folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        write_private(self._folder / "credentials", f"{self.credentials.user}:{self.credentials.password}\n".encode())
        self._process = await self._spawn()
        self._keeper = asyncio.create_task(self._keep(self._process))

    def connect_to(self, routers: tuple[str, ...]) -> None:
        """Connect to further routers of other hosts; the router is restarted for that, and its clients reconnect."""
        if self._peering is None or set(routers) <= set(self._peering.connect):
            return
        connect = tuple(dict.fromkeys((*self._peering.connect, *routers)))
        self._peering = msgspec.structs.replace(self._peering, connect=connect)
        if self._process is not None and self._process.returncode is None:
            self._process.terminate()

    async def close(self) -> None:
        """Stop the router."""
        if self._keeper is not None:
            self._keeper.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._keeper
        if self._process is not None:
            await end(self._process, STOP_GRACE)
        for name in ("credentials", "router.sock", "router.sock.lock"):
            (self._folder / name).unlink(missing_ok=True)

    async def _spawn(self) -> Process:
        # In its own session, so that Ctrl-C in a terminal does not end it before the processes that use it.
        process = await asyncio.create_subprocess_exec(
            sys.executable, "-m", __spec__.name, stdin=PIPE, stdout=PIPE, start_new_session=True
        )
        if process.stdin is None or process.stdout is None:
            raise RuntimeError("the router has no pipes")
        try:
            file = str(self._folder / "credentials")
            settings = RouterSettings(self._listen, file, self.credentials, self._peering)
            process.stdin.write(msgspec.json.encode(settings) + b"\n")
            async with asyncio.timeout(START_TIMEOUT):
                line = await process.stdout.readline()
        except BaseException:
            await end(process, STOP_GRACE)
            raise
        if line != READY:
            raise Unavailable(f"the router exited with status {await process.wait()} before it listened; see its log")
        return process

    async def _keep(self, process: Process) -> None:
        loop = asyncio.get_running_loop()
        while True:
            began = loop.time()
            status = await _ended(process)
            logger.error("the router exited with status %s and is restarted", status)
            # A router that ran for a while is restarted at once; one that fails at its start would spin.
            if loop.time() - began < STEADY:
                await asyncio.sleep(RETRY)
            process = self._process = await self._respawn()
            self.restarts += 1

    async def _respawn(self) -> Process:
        while True:
            try:
                return await self._spawn()
            except (Unavailable, OSError, TimeoutError):
                logger.exception("the router did not start; trying again")
                await asyncio.sleep(RETRY)


async def _ended(process: Process) -> int:
    """Wait until a router exits, or is killed because it is frozen; return its status."""
    watching = asyncio.create_task(_watch(process))
    try:
        return await process.wait()
    finally:
        watching.cancel()
        await asyncio.gather(watching, return_exceptions=True)


async def _watch(process: Process) -> None:
    assert process.stdin is not None and process.stdout is not None
    heartbeats, beats = Heartbeats(), 1
    while not heartbeats.check({"router": beats}):
        process.stdin.write(b"?")
        await asyncio.sleep(BEAT_PERIOD)
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(ANSWER_GRACE):
                beats += len(await process.stdout.read(4096))
    logger.error("the router missed %d heartbeats: it is frozen and is killed", MISSED)
    process.kill()


def main() -> None:
    """Run a router with the settings on standard input."""
    serve(from_json(sys.stdin.buffer.readline(), RouterSettings))


if __name__ == "__main__":
    main()
