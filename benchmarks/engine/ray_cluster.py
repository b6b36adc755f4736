"""A Ray cluster on this host: each node has a loopback address of its own, as each host has an address."""

import contextlib
import os
import secrets
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Generic, TypeVar

import psutil

from benchmarks.harness.free_ports import free_ports
from ppaas.errors import Unavailable

RAY = (sys.executable, "-m", "ray.scripts.scripts", "start", "--block")
SMALL = ("--disable-usage-stats", "--object-store-memory=80000000")
HEAD_ALONE = ("--num-cpus=0", "--include-dashboard=false", "--no-monitor", "--include-log-monitor=false")
STARTED = "Ray runtime started"
START_TIMEOUT = 60.0
END_TIMEOUT = 10.0
BLINK = 0.05

HEAD = "127.0.0.2"

CORES = 2
"""That a node says it has."""


class LocalRayNode:
    """A node: ``ray start``, and all below it.

    Parameters
    ----------
    address : str
        Its own, of the loopback network.
    arguments : str
        Of ``ray start``.
    environment : dict of str to str
        For it, and all below.
    log : Path
        Where it tells what it does.
    """

    name = ""
    """Of the machine that it is, once it is one."""

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
        """Wait until it is part of its cluster.

        Raises
        ------
        Unavailable
            It ended, or takes too long.
        """
        deadline = time.monotonic() + START_TIMEOUT
        while STARTED not in (said := self.log.read_text()):
            if self.process.poll() is not None or time.monotonic() > deadline:
                raise Unavailable(f"a node of Ray did not start (is the extra ppaas[ray] installed?):\n{said[-1000:]}")
            time.sleep(BLINK)

    def family(self) -> list[psutil.Process]:
        """Return all processes of it, those that are its own machine's agent and containers as well."""
        with contextlib.suppress(psutil.NoSuchProcess):
            top = psutil.Process(self.process.pid)
            return [top, *top.children(recursive=True)]
        return []

    def kill(self) -> None:
        """End all of it at a time, as if its power were cut."""
        self._signal(signal.SIGKILL)

    def freeze(self) -> None:
        """Let all of it stand still."""
        self._signal(signal.SIGSTOP)

    def _signal(self, number: int) -> None:
        for process in self.family():
            with contextlib.suppress(psutil.NoSuchProcess):
                process.send_signal(number)

    def end(self) -> None:
        """End all of it by force, and wait until it is gone."""
        family = self.family()
        self.kill()
        self.process.wait(END_TIMEOUT)
        psutil.wait_procs(family, END_TIMEOUT)


Node = TypeVar("Node", bound=LocalRayNode)


class LocalRayCluster(Generic[Node]):
    """A cluster of which the head has no cores, with a token that whoever takes part in it must have.

    Parameters
    ----------
    kind : type of LocalRayNode
        Of its nodes.
    environment : str
        Variables of all its nodes, beside what this process has.

    Attributes
    ----------
    address : str
        Of the head, ``host:port``.
    credentials : dict of str to str
        Variables of whoever may take part.
    runs : Path
        Where all that runs on the nodes has its temporary files.

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
        node.wait_until_up()  # two that begin at a time on one host disturb each other
        return node

    def join(self, *arguments: str, cores: int = CORES) -> Node:
        """Return a node that has joined; Ray tells of it a moment later.

        Raises
        ------
        Unavailable
            It does not start.
        """
        return self._begin(f"--address={self.address}", f"--num-cpus={cores}", *arguments)

    def stop(self) -> None:
        """End all nodes by force, and remove what they kept."""
        self._end_by_force()

    def _end_by_force(self) -> None:
        for node in reversed(self.nodes):
            node.end()
        shutil.rmtree(self.folder, ignore_errors=True)
