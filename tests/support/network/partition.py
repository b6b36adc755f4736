"""Network partitions between a cloud and a machine of another host: packets are lost silently."""

import os
import shutil
import subprocess
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlsplit

import msgspec
import pytest

from engine.remote.joining import read_ticket
from tests.support.cloud.joined_machine import ticket
from tests.support.network.wire import wire_to

NOBODY = "02:00:00:00:00:01"
"""Link-layer address that no host has: packets sent there are lost without an error."""


@dataclass(frozen=True)
class NetworkPath:
    """Network path to a cloud.

    Parameters
    ----------
    cut, mend : callable
        Start and stop losing all packets.
    within : tuple of str
        Command prefix of the machine at the other end.
    """

    cut: Callable[[], None]
    mend: Callable[[], None]
    within: tuple[str, ...] = ()


@asynccontextmanager
async def through_a_proxy(data: Path, machine: str) -> AsyncIterator[tuple[NetworkPath, str]]:
    """Yield a path for a machine's links that bypasses the fabric, and a ticket for the machine."""
    direct = read_ticket(ticket(data, "--host", "127.0.0.1", "--name", machine))
    async with wire_to(f"http://{direct.address.authority}") as wire:
        port = urlsplit(wire.url).port
        assert port is not None
        yield NetworkPath(wire.stall, wire.flow), str(msgspec.structs.replace(direct, port=port))


class Namespace:
    """Network namespace with a single link, to this one."""

    def __init__(self) -> None:
        number = os.getpid()
        self._name = f"ppaas-{number}"
        self._near, self._far = f"pp{number}n", f"pp{number}f"
        self.address, self._inside = (f"10.213.{number // 64 % 256}.{number % 64 * 4 + end}" for end in (1, 2))

    def add(self) -> None:
        """Create the namespace, or skip the test if that is not permitted."""
        made = shutil.which("ip") is not None and _ip("netns", "add", self._name, check=False)
        if not made:
            pytest.skip("network namespaces are not allowed here")
        _ip("link", "add", self._near, "type", "veth", "peer", "name", self._far, "netns", self._name)
        _ip("address", "add", f"{self.address}/30", "dev", self._near)
        _ip("link", "set", self._near, "up")
        self._inner("address", "add", f"{self._inside}/30", "dev", self._far)
        self._inner("link", "set", self._far, "up")

    def remove(self) -> None:
        """Remove the namespace and its link."""
        _ip("netns", "delete", self._name, check=False)

    @property
    def way(self) -> NetworkPath:
        """Path from the namespace to this one."""
        return NetworkPath(self._cut, self._mend, ("ip", "netns", "exec", self._name))

    def _cut(self) -> None:
        _ip("neigh", "replace", self._inside, "lladdr", NOBODY, "dev", self._near, "nud", "permanent")
        self._inner("neigh", "replace", self.address, "lladdr", NOBODY, "dev", self._far, "nud", "permanent")

    def _mend(self) -> None:
        _ip("neigh", "delete", self._inside, "dev", self._near)
        self._inner("neigh", "delete", self.address, "dev", self._far)

    def _inner(self, *words: str) -> None:
        _ip("-netns", self._name, *words)


def _ip(*words: str, check: bool = True) -> bool:
    return subprocess.run(["ip", *words], check=check, capture_output=True).returncode == 0
