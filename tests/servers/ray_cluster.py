"""A real Ray cluster on this machine: each node has a loopback address of its own, as each host has an address."""

import contextlib
import os
import secrets
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import psutil

from tests.servers.java_server import free_ports

START_TIMEOUT = 60.0
END_TIMEOUT = 60.0
STARTED = "Ray runtime started"

RAY = (sys.executable, "-m", "ray.scripts.scripts")

ATTENTIVE = {
    f"RAY_health_check_{name}": value
    for name, value in {
        "period_ms": "500", "timeout_ms": "10000", "failure_threshold": "3", "initial_delay_ms": "500",
    }.items()
}  # fmt: skip
"""A node that is dead refuses to be asked, and is told of after a second or two and not after fourteen. One that only
waits for a busy computer answers late, and has as long for it as Ray gives by itself."""


class RayNode:
    """A node: ``ray start --block``, and all below it.

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

    def __init__(self, address: str, *arguments: str, environment: dict[str, str], log: Path) -> None:
        self.address = address
        self.log = log
        small = ("--disable-usage-stats", "--object-store-memory=80000000")
        command = (*RAY, "start", "--block", f"--node-ip-address={address}", *small, *arguments)
        with log.open("wb") as output:
            self.process = subprocess.Popen(
                command, stdout=output, stderr=output, env=environment, start_new_session=True
            )

    def wait_until_up(self) -> None:
        """Wait until it is part of its cluster."""
        deadline = time.monotonic() + START_TIMEOUT
        while STARTED not in self.log.read_text():
            assert self.process.poll() is None and time.monotonic() < deadline, self.log.read_text()
            time.sleep(0.05)

    def family(self) -> list[psutil.Process]:
        """Return all processes of it, those that are its own machine's agent and containers as well."""
        with contextlib.suppress(psutil.NoSuchProcess):
            top = psutil.Process(self.process.pid)
            return [top, *top.children(recursive=True)]
        return []

    def find(self, *words: str) -> list[psutil.Process]:
        """Return the processes with all the words in their command line."""
        found = []
        for process in self.family():
            with contextlib.suppress(psutil.NoSuchProcess):  # it ended just now
                if all(word in " ".join(process.cmdline()) for word in words):
                    found.append(process)
        return found

    def agent(self) -> psutil.Process:
        """Return the agent of its machine; one whose actor was killed may be about to end."""
        return max(self.find("engine.ray_nodes.agent"), key=lambda process: process.create_time())

    def raylet(self) -> psutil.Process:
        """Return what makes it a node; what it is about to start is called as it is for a moment."""
        return min(self.find("raylet/raylet", "--raylet_socket_name"), key=lambda process: process.create_time())

    def cut_power(self) -> None:
        """Kill all of it at a time."""
        _kill(self.family())
        self.process.wait(END_TIMEOUT)

    def leave(self) -> None:
        """Have it leave its cluster, as ``ray stop`` does, which ends every process of Ray on its host."""
        family = self.family()
        raylet = self.raylet()
        raylet.terminate()
        psutil.wait_procs([raylet], END_TIMEOUT)
        self.process.terminate()
        self.process.wait(END_TIMEOUT)
        _, alive = psutil.wait_procs(family, END_TIMEOUT)
        _kill(alive)
        assert not alive, f"left behind by node {self.address}: {alive}"


class RayCluster:
    """A cluster of which the head has no cores, with a token that whoever takes part in it must have.

    Parameters
    ----------
    environment : dict of str to str
        Of all its nodes, beside what this process has.
    """

    def __init__(self, **environment: str) -> None:
        self.folder = Path(tempfile.mkdtemp(prefix="ray-"))  # sockets need a short path
        self.token = self.folder / "token"
        self.token.write_text(secrets.token_hex(32))
        self.runs = self.folder / "runs"
        self.runs.mkdir()
        self.credentials = {"RAY_AUTH_MODE": "token", "RAY_AUTH_TOKEN_PATH": str(self.token)}
        self._environment = {**os.environ, **ATTENTIVE, **self.credentials, **environment, "TMPDIR": str(self.runs)}
        (port,) = free_ports(1)
        self.address = f"127.0.0.2:{port}"
        self.nodes: list[RayNode] = []
        alone = ("--include-dashboard=false", "--no-monitor", f"--temp-dir={self.folder / 'ray'}")
        self._begin("--head", f"--port={port}", "--num-cpus=0", "--include-log-monitor=false", *alone)

    def _begin(self, *arguments: str) -> RayNode:
        number = len(self.nodes) + 2
        log = self.folder / f"node-{number}.log"
        node = RayNode(f"127.0.0.{number}", *arguments, environment=self._environment, log=log)
        self.nodes.append(node)
        node.wait_until_up()  # two that begin at a time on one host disturb each other
        return node

    def join(self, *arguments: str, cores: int = 2) -> RayNode:
        """Return a node that has joined; Ray tells of it a moment later."""
        return self._begin(f"--address={self.address}", f"--num-cpus={cores}", *arguments)

    def _wait_until_clean(self) -> None:
        """Wait until the last agents have ended by themselves, and left nothing."""
        deadline = time.monotonic() + END_TIMEOUT
        while left := sorted(path.name for path in self.runs.glob("ppaas-*")):
            assert time.monotonic() < deadline, f"left in the folder for temporary files: {left}"
            time.sleep(0.05)

    def stop(self) -> None:
        """End all nodes, the head last, and look at whether something was left."""
        try:
            for node in reversed(self.nodes):
                if node.process.poll() is None:
                    node.leave()
            self._wait_until_clean()
        finally:
            for node in self.nodes:
                _kill(node.family())
            shutil.rmtree(self.folder, ignore_errors=True)


def _kill(processes: list[psutil.Process]) -> None:
    for process in processes:
        with contextlib.suppress(psutil.NoSuchProcess):
            process.kill()
