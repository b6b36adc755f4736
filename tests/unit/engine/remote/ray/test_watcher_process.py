"""The loop of the watcher, and its process, which is kept running; a script replaces the watcher."""

import asyncio
import contextlib
import os
import signal
import socket
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

from engine.remote.ray import watcher_process
from engine.remote.ray.config import WatchConfig
from engine.remote.ray.watcher import serve
from engine.remote.ray.watcher_process import WatcherProcess, read_address
from ppaas import distribution
from ppaas.errors import InvalidInput, Unavailable
from tests.support.waiting import until

STAND_IN = (sys.executable, "-m", "tests.support.engine.watcher_stand_in")


@pytest.fixture
def head() -> Iterator[str]:
    """Return the address of a listening socket."""
    with contextlib.closing(socket.create_server(("127.0.0.1", 0))) as listener:
        yield "127.0.0.1:{1}".format(*listener.getsockname())


class Watched:
    """A ``WatcherProcess``, and the file that the script writes."""

    def __init__(self, folder: Path, address: str, does: str = "stay") -> None:
        self.file = folder / "watchers"
        self.process = WatcherProcess(WatchConfig(address, str(folder), does), STAND_IN)

    def noted(self) -> list[str]:
        return self.file.read_text().splitlines()


async def test_the_watcher_gets_frozen_machines_and_the_stop_command(tmp_path: Path, head: str) -> None:
    watched = Watched(tmp_path, head)
    await watched.process.start()
    pid = watched.process.pid
    watched.process.kill("m1")
    await watched.process.stop()
    assert watched.noted() == [str(pid), "m1", "end all"]


async def test_a_watcher_that_dies_is_started_again(tmp_path: Path, head: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(watcher_process, "RETRY", 0.01)
    watched = Watched(tmp_path, head)
    await watched.process.start()
    psutil.Process(watched.process.pid).send_signal(signal.SIGKILL)
    await until(lambda: len(watched.noted()) == 2)
    await watched.process.stop()


async def test_commands_to_a_watcher_that_has_exited_are_dropped_with_a_warning(
    tmp_path: Path, head: str, caplog: pytest.LogCaptureFixture
) -> None:
    watched = Watched(tmp_path, head)
    await watched.process.start()
    psutil.Process(watched.process.pid).send_signal(signal.SIGKILL)
    await until(lambda: "exited with status -9" in caplog.text)
    watched.process.kill("m1")
    await watched.process.stop()
    assert caplog.text.count("it gets no commands") == 2
    assert len(watched.noted()) == 1


@pytest.mark.parametrize(("does", "expected"), [("refuse", "wrong token"), ("crash", "status 3")])
async def test_failed_connection_is_reported_with_its_reason(
    tmp_path: Path, head: str, does: str, expected: str
) -> None:
    watched = Watched(tmp_path, head, does)
    with pytest.raises(Unavailable, match=expected):
        await watched.process.start()
    await watched.process.stop()


async def test_without_a_listening_cluster_no_watcher_is_started(tmp_path: Path, head: str) -> None:
    with contextlib.closing(socket.create_server(("127.0.0.1", 0))) as listener:
        port = listener.getsockname()[1]
    watched = Watched(tmp_path, f"127.0.0.1:{port}")
    with pytest.raises(Unavailable, match=f"ray start --head --port={port}"):
        await watched.process.start()
    await watched.process.stop()
    assert watched.process.pid is None


async def test_a_missing_extra_is_named(tmp_path: Path, head: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(watcher_process.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(InvalidInput, match=r"\.\[ray\]"):
        Watched(tmp_path, head)


async def test_an_old_ray_is_named(tmp_path: Path, head: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(distribution, "version", lambda name: "2.9.3")
    with pytest.raises(Unavailable, match=r"ray 2\.9\.3 \(needed: >="):
        Watched(tmp_path, head)


def test_valid_addresses_are_parsed() -> None:
    assert read_address("auto") is None
    assert read_address("ray.example:6379") == ("ray.example", 6379)
    assert read_address("[::1]:6379") == ("::1", 6379)


@pytest.mark.parametrize("text", ["", "host", "host:", ":6379", "host:port", "host:99999", "ray://host:1", "a:1/b"])
def test_an_invalid_address_is_refused(text: str) -> None:
    with pytest.raises(InvalidInput, match="host:port"):
        read_address(text)


async def test_stopping_an_unstarted_process_does_nothing(tmp_path: Path, head: str) -> None:
    process = Watched(tmp_path, head).process
    process.kill("m1")
    await asyncio.wait_for(process.stop(), 1.0)


class FakeSupervisor:
    """Replaces the supervisor, and records its calls."""

    def __init__(self) -> None:
        self.calls: list[str] = []
        self.looked = threading.Event()

    def reconcile(self) -> None:
        self.looked.set()

    def kill_agent(self, machine: str) -> None:
        self.calls.append(machine)

    def end_all(self) -> None:
        self.calls.append("end all")


@pytest.mark.parametrize(("commands", "calls"), [(b"m1\nm2\n\n", ["m1", "m2", "end all"]), (b"m1\n", ["m1"])])
def test_watcher_stops_agents_on_command_only(commands: bytes, calls: list[str]) -> None:
    reading, writing = os.pipe()
    supervisor = FakeSupervisor()
    serving = threading.Thread(target=serve, args=(supervisor, reading))
    serving.start()
    assert supervisor.looked.wait(10.0)
    os.write(writing, commands[:4])
    os.write(writing, commands[4:])
    os.close(writing)
    serving.join(10.0)
    os.close(reading)
    assert supervisor.calls == calls
