"""The watcher of a Ray cluster, as a process that is restarted whenever it exits, and the machines that it starts."""

import asyncio
import contextlib
import importlib.util
import logging
import os
import sys
from asyncio.subprocess import PIPE, Process
from collections.abc import Sequence
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

import msgspec

from engine.fabric.router import RouterProcess
from engine.processes.child_process import end
from engine.protocols.refusals import error_of
from engine.remote.ray.config import WatchAnswer, WatchConfig, WatchRefused
from ppaas.decoding import from_json
from ppaas.distribution import check_versions, install_hint
from ppaas.errors import InvalidInput, Unavailable

if TYPE_CHECKING:
    from engine.remote.ray import watcher  # noqa: F401

logger = logging.getLogger(__name__)

AUTO = "auto"
"""Address of the cluster on this host."""

PROBE_TIMEOUT = 3.0

CONNECT_TIMEOUT = 60.0

STOP_GRACE = 20.0

CONNECT_TRIES = {"RAY_NUM_REDIS_GET_RETRIES": "5"}
"""Number of attempts, one per second, before Ray gives up connecting; the port was probed before."""

RETRY = 1.0
"""Delay before a watcher is restarted [s]; agents run on meanwhile, but none joins."""

WATCHER = "engine.remote.ray.watcher"
"""Module of the watcher, by name: this process must not import Ray."""

COMMAND = (sys.executable, "-m", WATCHER)


class WatcherProcess:
    """Keeps a watcher running.

    Parameters
    ----------
    config : WatchConfig
        Settings of the watcher.
    command : sequence of str
        Command that runs the watcher.

    Raises
    ------
    InvalidInput
        The extra ``ray`` is not installed, or the address is invalid.
    Unavailable
        Ray is older than tried.
    """

    def __init__(self, config: WatchConfig, command: Sequence[str] = COMMAND) -> None:
        if importlib.util.find_spec("ray") is None:
            raise InvalidInput(f"machines on Ray need the extra ray: {install_hint('ray')}")
        check_versions("ray")
        self._config = config
        self._command = command
        self._endpoint = read_address(config.address)
        self._process: Process | None = None
        self._keeper: asyncio.Task[None] | None = None

    @property
    def pid(self) -> int | None:
        """Process id of the running watcher."""
        return self._process.pid if self._process is not None else None

    async def start(self) -> None:
        """Connect to the cluster, and watch it from now on.

        Raises
        ------
        Unavailable
            The cluster does not exist, or refuses the connection.
        """
        if self._endpoint is not None:
            await _probe(*self._endpoint)
        self._process = await self._spawn()
        self._keeper = asyncio.create_task(self._keep(self._process))

    async def _keep(self, process: Process) -> None:
        while True:
            status = await process.wait()
            logger.error("the watcher of the Ray cluster exited with status %s and is restarted", status)
            process = self._process = await self._respawn()

    async def _respawn(self) -> Process:
        while True:
            await asyncio.sleep(RETRY)
            try:
                return await self._spawn()
            except (Unavailable, OSError) as error:
                logger.warning("the watcher of the Ray cluster cannot be restarted; trying again: %s", error)

    async def _spawn(self) -> Process:
        # In its own session, so that Ctrl-C in a terminal does not end it before the agents.
        process = await asyncio.create_subprocess_exec(
            *self._command, stdin=PIPE, stdout=PIPE, start_new_session=True, env=CONNECT_TRIES | os.environ
        )
        if process.stdin is None or process.stdout is None:
            raise RuntimeError("the watcher has no pipes")
        try:
            process.stdin.write(msgspec.json.encode(self._config) + b"\n")
            async with asyncio.timeout(CONNECT_TIMEOUT):
                line = await process.stdout.readline()
        except BaseException as error:
            await end(process, 0.0)
            if isinstance(error, TimeoutError):
                raise Unavailable(f"the Ray cluster at {self._config.address} does not answer") from error
            raise
        if not line:
            raise Unavailable(f"the watcher of the Ray cluster exited with status {await process.wait()}; see its log")
        answer: WatchAnswer = from_json(line, WatchAnswer)
        if isinstance(answer, WatchRefused):
            await process.wait()
            raise error_of(answer.refusal)
        return process

    def kill(self, machine: str) -> None:
        """Kill the frozen agent of a machine; it is restarted. A watcher that has just exited kills none."""
        self._write(machine)

    async def stop(self) -> None:
        """Stop all agents, and the watcher."""
        if self._keeper is not None:
            self._keeper.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._keeper
        if self._process is not None:
            self._write("")
            await end(self._process, STOP_GRACE)

    def _write(self, line: str) -> None:
        """Write a line to the watcher, unless it has exited: its pipe is closed then, and refuses writes."""
        if self._process is None or self._process.stdin is None or self._process.stdin.is_closing():
            logger.warning("the watcher of the Ray cluster does not run; it gets no commands")
            return
        self._process.stdin.write(line.encode() + b"\n")


def read_address(text: str) -> tuple[str, int] | None:
    """Return host and port of a cluster's head, or None for the cluster that Ray finds on this host (``auto``).

    Raises
    ------
    InvalidInput
        The text is neither ``host:port`` nor ``auto``.
    """
    if text == AUTO:
        return None
    try:
        parts = urlsplit(f"//{text}")
        if parts.hostname and parts.port and parts.netloc == text:
            return parts.hostname, parts.port
    except ValueError as error:
        raise InvalidInput(_invalid_address(text)) from error
    raise InvalidInput(_invalid_address(text))


def _invalid_address(text: str) -> str:
    return f"{text!r} is not the address of a Ray cluster: write host:port of its head, or {AUTO}"


async def _probe(host: str, port: int) -> None:
    """Check that the port is open: Ray itself tries for more than a minute, and then ends the process."""
    try:
        async with asyncio.timeout(PROBE_TIMEOUT):
            _, writer = await asyncio.open_connection(host, port)
    except (OSError, TimeoutError) as error:
        raise Unavailable(
            f"no Ray cluster answers at {host}:{port}; start one with: ray start --head --port={port}"
        ) from error
    writer.close()


class RayMachines:
    """Keeps an agent on each node, in place of the agent of the local machine.

    Parameters
    ----------
    watcher : WatcherProcess
        Watcher of the cluster.
    router : RouterProcess
        Router of the cloud, which the routers of the nodes connect to. There is no local agent to start it.
    """

    expected_at_start = False  # nodes may join at any time
    was_adopted: bool = False
    deaths: int = 0

    def __init__(self, watcher: WatcherProcess, router: RouterProcess) -> None:
        self._watcher = watcher
        self._router = router

    async def start(self) -> None:
        """Start the watcher, which starts agents. There may be no node yet.

        Raises
        ------
        Unavailable
            The cluster does not exist, or refuses the connection.
        """
        await self._router.start()
        await self._watcher.start()

    def kill(self, machine: str) -> None:
        """Kill the frozen agent of a machine; it is restarted."""
        self._watcher.kill(machine)

    async def stop(self) -> None:
        """Stop all agents."""
        await self._watcher.stop()
        await self._router.close()
