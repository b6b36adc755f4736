"""A Ray cluster on this host, each node with a loopback address of its own, as each host has an address."""

import asyncio
import contextlib
import os
import secrets
import signal
import socket
import sys
import tempfile
from collections.abc import AsyncIterator
from pathlib import Path

import psutil

from ppaas.errors import Unavailable
from robots.bench.engine.site import machines_beyond
from robots.bench.target import Target

RAY = (sys.executable, "-m", "ray.scripts.scripts", "start", "--block")
SMALL = ("--disable-usage-stats", "--object-store-memory=80000000")
HEAD_ALONE = ("--num-cpus=0", "--include-dashboard=false", "--no-monitor", "--include-log-monitor=false")
STARTED = "Ray runtime started"
START_TIMEOUT = 60.0
END_TIMEOUT = 10.0
CORES = 2
"""That each node says it has."""


class RayNode:
    """A node: ``ray start``, and all below it.

    Parameters
    ----------
    process : Process
        That was started, in a session of its own.
    log : Path
        What it says.
    """

    name = ""
    """Of the machine that it is, once it is one."""

    def __init__(self, process: asyncio.subprocess.Process, log: Path) -> None:
        self._process = process
        self._log = log

    async def is_up(self) -> None:
        """Wait until it is part of its cluster.

        Raises
        ------
        Unavailable
            It ended, or takes too long.
        """
        deadline = asyncio.get_running_loop().time() + START_TIMEOUT
        while STARTED not in (said := await asyncio.to_thread(self._log.read_text)):
            if self._process.returncode is not None or asyncio.get_running_loop().time() > deadline:
                raise Unavailable(f"a node of Ray did not start (is the extra ppaas[ray] installed?):\n{said[-1000:]}")
            await asyncio.sleep(0.05)

    def kill(self) -> None:
        """End all of it at a time, as if its power were cut."""
        self._signal(signal.SIGKILL)

    def freeze(self) -> None:
        """Let all of it stand still."""
        self._signal(signal.SIGSTOP)

    def _signal(self, number: int) -> None:
        for process in self._family():
            with contextlib.suppress(psutil.NoSuchProcess):
                process.send_signal(number)

    def _family(self) -> list[psutil.Process]:
        with contextlib.suppress(psutil.NoSuchProcess):
            top = psutil.Process(self._process.pid)
            return [top, *top.children(recursive=True)]
        return []

    async def end(self) -> None:
        """End all of it, by force; what is below it goes as well."""
        family = self._family()
        self.kill()
        await self._process.wait()
        await asyncio.to_thread(psutil.wait_procs, family, END_TIMEOUT)


class RayHosts:
    """The nodes of a cluster; use ``ray_hosts``.

    Parameters
    ----------
    folder : Path
        For what Ray keeps; its path is short, for sockets.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        token = folder / "token"
        token.write_text(secrets.token_hex(32))
        self.environment = {"RAY_AUTH_MODE": "token", "RAY_AUTH_TOKEN_PATH": str(token)}
        with socket.create_server(("127.0.0.2", 0)) as free:
            self._address = f"127.0.0.2:{free.getsockname()[1]}"
        self.arguments: tuple[str, ...] = (
            "--runtime",
            "ray",
            "--ray-address",
            self._address,
            "--listen-machines",
            "127.0.0.1:0",
        )
        self._count = 1

    @contextlib.asynccontextmanager
    async def node(self, *arguments: str) -> AsyncIterator[RayNode]:
        """Start a node; all of it is gone afterwards."""
        self._count += 1
        log = self._folder / f"node-{self._count}.log"
        with log.open("wb") as output:
            process = await asyncio.create_subprocess_exec(
                *RAY, f"--node-ip-address=127.0.0.{self._count}", *SMALL, *arguments, stdin=asyncio.subprocess.DEVNULL,
                stdout=output, stderr=output, env=os.environ | self.environment | {"TMPDIR": str(self._folder)},
                start_new_session=True,
            )  # fmt: skip
        node = RayNode(process, log)
        try:
            await node.is_up()
            yield node
        finally:
            await node.end()

    def head(self) -> contextlib.AbstractAsyncContextManager[RayNode]:
        """Start the head, which carries nothing."""
        port = self._address.rpartition(":")[2]
        return self.node("--head", f"--port={port}", f"--temp-dir={self._folder / 'ray'}", *HEAD_ALONE)

    def worker(self) -> contextlib.AbstractAsyncContextManager[RayNode]:
        """Start a node that can be a machine."""
        return self.node(f"--address={self._address}", f"--num-cpus={CORES}")

    @contextlib.asynccontextmanager
    async def joined(self, target: Target, folder: Path) -> AsyncIterator[RayNode]:
        """Start a node, and wait until it is a machine of a cloud."""
        known = [view["id"] for view in await target.rest.items("/v1/machines")]
        async with self.worker() as node:
            node.name = (await machines_beyond(target, known))[0]
            yield node


@contextlib.asynccontextmanager
async def ray_hosts() -> AsyncIterator[RayHosts]:
    """Start a cluster with a node, and end it afterwards."""
    with tempfile.TemporaryDirectory(prefix="r-", ignore_cleanup_errors=True) as name:
        hosts = RayHosts(Path(name))
        async with hosts.head(), hosts.worker():
            yield hosts
