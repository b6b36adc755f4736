"""Notifications reach a socket as systemd opens it."""

import asyncio
import os
import socket
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from engine.processes.service_manager import ServiceManager


@pytest.fixture(params=["path", "abstract"])
def manager(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[tuple[socket.socket, dict[str, str]]]:
    """Return the socket of a manager, and the environment that it gives to a service."""
    address = str(tmp_path / "notify") if request.param == "path" else f"@ppaas-test-{os.getpid()}"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listening:
        listening.bind(address.replace("@", "\0", 1) if address.startswith("@") else address)
        listening.settimeout(5.0)
        yield listening, {"NOTIFY_SOCKET": address, "OTHER": "kept"}


def test_states_are_sent_and_children_inherit_nothing(manager: tuple[socket.socket, dict[str, str]]) -> None:
    listening, environment = manager
    service = ServiceManager(environment)
    service.notify(READY="1", STATUS="serving at http://127.0.0.1:8500")
    assert listening.recv(4096) == b"READY=1\nSTATUS=serving at http://127.0.0.1:8500"
    assert environment == {"OTHER": "kept"}
    assert service.period is None


@pytest.mark.parametrize("pid", ["", str(os.getpid())])
async def test_signs_of_life_are_sent_in_half_the_time(manager: tuple[socket.socket, dict[str, str]], pid: str) -> None:
    listening, environment = manager
    service = ServiceManager(environment | {"WATCHDOG_USEC": "20000", "WATCHDOG_PID": pid})
    assert service.period == pytest.approx(0.01)
    service.start()
    for _ in range(3):
        assert await asyncio.to_thread(listening.recv, 100) == b"WATCHDOG=1"
    await service.stop()
    listening.settimeout(0.0)
    left = []
    with suppress(BlockingIOError):
        while True:
            left.append(listening.recv(100))
    assert left[-1] == b"STOPPING=1"


@pytest.mark.parametrize("given", [{}, {"WATCHDOG_USEC": "20000", "WATCHDOG_PID": "1"}, {"WATCHDOG_USEC": "soon"}])
async def test_none_are_sent_that_nobody_expects(given: dict[str, str]) -> None:
    service = ServiceManager(dict(given))
    service.start()
    service.notify(READY="1")
    assert service.period is None
    await service.stop()


def test_a_manager_that_is_gone_is_no_error(tmp_path: Path) -> None:
    ServiceManager({"NOTIFY_SOCKET": str(tmp_path / "gone")}).notify(STOPPING="1")
