"""Ray cluster on this host, with a loopback address for each node, and machines on its nodes."""

import asyncio
import contextlib
import os
import secrets
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Generic, TypeVar

import psutil

from benchmarks.engine.site import machines_beyond
from benchmarks.harness.cloud_under_test import CloudUnderTest
from benchmarks.harness.free_ports import free_ports
from ppaas.errors import Unavailable

RAY = (sys.executable, "-m", "ray.scripts.scripts", "start", "--block")
SMALL = ("--disable-usage-stats", "--object-store-memory=80000000")
HEAD_ALONE = ("--num-cpus=0", "--include-dashboard=false", "--no-monitor", "--include-log-monitor=false")
STARTED = "Ray runtime started"
START_TIMEOUT = 60.0
"""Time within which a node must have started [s]."""
END_TIMEOUT = 10.0
"""Time within which killed processes must have exited [s]."""
BLINK = 0.05
"""Period at which the log of a starting node is read [s]."""

HEAD = "127.0.0.2"
"""Address of the head node."""

CORES = 2
"""Number of cores that a node declares."""


class LocalRayNode:
    """A node: the process of ``ray start`` and its descendants.

    Parameters
    ----------
    address : str
        Its loopback address.
    arguments : str
        Further arguments of ``ray start``.
    environment : dict of str to str
        Environment of its processes.
    log : Path
        File of its output.
    """

    name = ""
    """Name of its machine, once it has joined a cloud."""

    def __init__(self, address: str, *arguments: str, environment: dict[str, str], log: Path) -> None:
        self.address = address
        self.log = log
        with log.open("wb") as output:
            self.process = subprocess.Popen(
                [*RAY, f"--node-ip-address={address}", *SMALL, *arguments],
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=output,
                env=environment,
                start_new_session=True,
            )

    def wait_until_up(self) -> None:
        """Wait until the node has joined its cluster.

        Raises
        ------
        Unavailable
            The node exited, or did not start within the time limit.
        """
        deadline = time.monotonic() + START_TIMEOUT
        while STARTED not in (said := self.log.read_text()):
            if self.process.poll() is not None or time.monotonic() > deadline:
                raise Unavailable(f"a Ray node did not start (is the extra 'ray' installed?):\n{said[-1000:]}")
            time.sleep(BLINK)

    def family(self) -> list[psutil.Process]:
        """Return all processes of the node, including an agent and its containers."""
        with contextlib.suppress(psutil.NoSuchProcess):
            top = psutil.Process(self.process.pid)
            return [top, *top.children(recursive=True)]
        return []

    def kill(self) -> None:
        """Kill all of its processes at once, as a power failure would."""
        self._signal(signal.SIGKILL)

    def freeze(self) -> None:
        """Stop all of its processes by SIGSTOP."""
        self._signal(signal.SIGSTOP)

    def _signal(self, number: int) -> None:
        for process in self.family():
            with contextlib.suppress(psutil.NoSuchProcess):
                process.send_signal(number)

    def end(self) -> None:
        """Kill all of its processes, and wait until they have exited."""
        family = self.family()
        self.kill()
        self.process.wait(END_TIMEOUT)
        psutil.wait_procs(family, END_TIMEOUT)


Node = TypeVar("Node", bound=LocalRayNode)


class LocalRayCluster(Generic[Node]):
    """A cluster whose head has no cores; joining it needs a token.

    Parameters
    ----------
    kind : type of LocalRayNode
        Class of its nodes.
    environment : str
        Environment variables of the nodes, in addition to those of this process.

    Attributes
    ----------
    address : str
        Address of the head, ``host:port``.
    credentials : dict of str to str
        Environment variables with which a process may join.
    runs : Path
        Folder for temporary files of all processes of the nodes.

    Raises
    ------
    Unavailable
        The head does not start.
    """

    def __init__(self, kind: type[Node], **environment: str) -> None:
        self._kind = kind
        self.folder = Path(tempfile.mkdtemp(prefix="r-"))  # sockets need a short path
        token = self.folder / "token"
        token.write_text(secrets.token_hex(32))
        self.runs = self.folder / "runs"
        self.runs.mkdir()
        self.credentials = {"RAY_AUTH_MODE": "token", "RAY_AUTH_TOKEN_PATH": str(token)}
        self._environment = {**os.environ, **environment, **self.credentials, "TMPDIR": str(self.runs)}
        [port] = free_ports(1, HEAD)
        self.address = f"{HEAD}:{port}"
        self.nodes: list[Node] = []
        try:
            self._begin("--head", f"--port={port}", f"--temp-dir={self.folder / 'ray'}", *HEAD_ALONE)
        except Unavailable:
            self._end_by_force()
            raise

    def _begin(self, *arguments: str) -> Node:
        number = len(self.nodes) + 2
        log = self.folder / f"node-{number}.log"
        node = self._kind(f"127.0.0.{number}", *arguments, environment=self._environment, log=log)
        self.nodes.append(node)
        node.wait_until_up()  # nodes that start at the same time on one host disturb each other
        return node

    def join(self, *arguments: str, cores: int = CORES) -> Node:
        """Start a node that joins the cluster; Ray lists it a moment later.

        Raises
        ------
        Unavailable
            It does not start.
        """
        return self._begin(f"--address={self.address}", f"--num-cpus={cores}", *arguments)

    def stop(self) -> None:
        """Kill all nodes, and remove their files."""
        self._end_by_force()

    def _end_by_force(self) -> None:
        for node in reversed(self.nodes):
            node.end()
        shutil.rmtree(self.folder, ignore_errors=True)


# -- machines on the nodes of a Ray cluster on this host ---------------------------------------------------------------


class RayHosts:
    """Provides additional machines as Ray nodes; use ``ray_hosts``.

    Parameters
    ----------
    cluster : LocalRayCluster
        Cluster that they join.
    """

    def __init__(self, cluster: LocalRayCluster[LocalRayNode]) -> None:
        self._cluster = cluster
        at = ("--ray-address", cluster.address, "--listen-machines", "127.0.0.1:0")
        self.arguments: tuple[str, ...] = ("--runtime", "ray", *at)
        self.environment = cluster.credentials

    @contextlib.asynccontextmanager
    async def joined(self, target: CloudUnderTest, folder: Path) -> AsyncIterator[LocalRayNode]:
        """Start a node, wait until it is a machine of the cloud, and end it afterwards."""
        known = [view["id"] for view in await target.rest.items("/v1/machines")]
        node = await asyncio.to_thread(self._cluster.join)
        try:
            node.name = (await machines_beyond(target, known))[0]
            yield node
        finally:
            await asyncio.to_thread(node.end)


@contextlib.asynccontextmanager
async def ray_hosts() -> AsyncIterator[RayHosts]:
    """Start a cluster with a node, and end it afterwards.

    Raises
    ------
    Unavailable
        It does not start.
    """
    starting = asyncio.create_task(asyncio.to_thread(LocalRayCluster, LocalRayNode))
    try:
        cluster = await asyncio.shield(starting)
    except asyncio.CancelledError:
        await asyncio.to_thread((await starting).stop)  # the thread cannot be cancelled
        raise
    try:
        await asyncio.to_thread(cluster.join)
        yield RayHosts(cluster)
    finally:
        await asyncio.to_thread(cluster.stop)
