"""Joint: the fabric while its router dies, its readers sleep, and unauthorized clients connect."""

import asyncio
import contextlib
import itertools
import os
import signal
import sys
from asyncio.subprocess import PIPE, Process
from collections import Counter
from collections.abc import AsyncIterator, Callable
from types import ModuleType

import msgspec
import pytest
import zenoh

from engine.agent.entries import loaded_before
from engine.fabric.router import RouterProcess
from engine.fabric.session import Fabric
from engine.fabric.zenoh_config import RouterCredentials, client_config
from engine.runtimes.process.runtime import ProcessRuntime
from tests.stress.conftest import Figure
from tests.support.engine import fabric_reader, fabric_server
from tests.support.engine.launches import Reports
from tests.support.engine.processes import memory
from tests.support.sources import ROOT
from tests.support.waiting import patience, until

pytestmark = pytest.mark.joint

MB = 2**20


@pytest.fixture
async def router(tmp_path):
    process = RouterProcess(tmp_path / "run")
    await process.start()
    yield process
    await process.close()


@contextlib.asynccontextmanager
async def script(router: RouterProcess, module: ModuleType, *arguments: str) -> AsyncIterator[Process]:
    """Run a script that joins the fabric until the context ends."""
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-m", module.__name__, *arguments, cwd=ROOT, stdin=PIPE, stdout=PIPE
    )
    assert process.stdin is not None and process.stdout is not None
    process.stdin.write(msgspec.json.encode(fabric_server.Settings(router.endpoint, router.credentials)) + b"\n")
    async with patience(30):
        assert await process.stdout.readline() == b"ready\n"
    try:
        yield process
    finally:
        with contextlib.suppress(ProcessLookupError):
            process.send_signal(signal.SIGCONT)
        process.stdin.close()
        try:
            async with patience(10):
                await process.wait()
        except TimeoutError:
            process.kill()
            await process.wait()


class Requesters:
    """Send requests continuously, and record the answers."""

    def __init__(self, fabrics: list[Fabric]) -> None:
        self.answered: list[str] = []
        self.wrong: list[str] = []
        self.slowest = 0.0
        self._numbers = itertools.count()
        self._stop = False
        self._tasks = [asyncio.create_task(self._ask(fabric)) for fabric in fabrics]

    async def _ask(self, fabric: Fabric) -> None:
        loop = asyncio.get_running_loop()
        while not self._stop:
            text = f"request {next(self._numbers)}"
            began = loop.time()
            answer = await fabric.request("count", text.encode(), timeout=20.0)
            self.slowest = max(self.slowest, loop.time() - began)
            self.answered.append(text)
            if answer != text.encode()[::-1]:
                self.wrong.append(text)

    async def stop(self) -> None:
        self._stop = True
        await asyncio.gather(*self._tasks)


async def test_requests_are_neither_lost_nor_repeated_when_the_router_dies(tmp_path, router, seconds, figure):
    runtime = ProcessRuntime(loaded_before("tests.support.engine.container_entries:dial_and_stay"))
    await runtime.start()  # before any session, like an agent
    fabrics = [await Fabric.open(router.endpoint, router.credentials) for _ in range(3)]
    received: Counter[str] = Counter()
    for number, fabric in enumerate(fabrics):
        fabric.subscribe("position/*", lambda key, payload, n=number: received.update([f"{n} of {payload.decode()}"]))
    everyone = {f"{reader} of {writer}" for reader in range(3) for writer in range(3)}
    async with script(router, fabric_server):
        requesters = Requesters(fabrics * 3)
        recoveries = []
        loop = asyncio.get_running_loop()
        until_when = loop.time() + seconds
        while loop.time() < until_when:
            await publish_until_all_received(fabrics, received, everyone)
            assert router.pid is not None
            os.kill(router.pid, signal.SIGKILL)
            recoveries.append(await publish_until_all_received(fabrics, received, everyone, at_once=False))
            await asyncio.sleep(0.5)
        await requesters.stop()
        executed = Counter(msgspec.json.decode(await fabrics[0].request("tell", b""), type=list[str]))
    assert requesters.wrong == []
    assert set(executed) == set(requesters.answered)
    assert set(executed.values()) == {1}
    assert len(requesters.answered) > 100
    async with Reports(tmp_path) as reports:  # the fork server still works after the router died
        container = await runtime.launch(reports.launch())
        assert (await reports.next()).pid == container.pid
    figure("router deaths", float(len(recoveries)))
    figure("router killed to all publications heard again, worst, ms", max(recoveries) * 1000.0)
    figure("requests carried out", float(len(requesters.answered)))
    figure("slowest request, ms", requesters.slowest * 1000.0)
    await runtime.close()
    for fabric in fabrics:
        await fabric.close()


async def publish_until_all_received(
    fabrics: list[Fabric], received: "Counter[str]", everyone: set[str], *, at_once: bool = True
) -> float:
    """Publish from each fabric until each has received all; return the time [s]."""
    loop = asyncio.get_running_loop()
    began = loop.time()
    if not at_once:
        await asyncio.sleep(0.02)  # messages still in transit do not count
    received.clear()
    async with patience(10):
        while set(received) != everyone:
            for number, fabric in enumerate(fabrics):
                fabric.publish(f"position/{number}", str(number).encode())
            await asyncio.sleep(0.01)
    return loop.time() - began


class Feed:
    """Publishes 200 numbered messages of 10 KB a second, and measures how long each call blocks the loop."""

    def __init__(self, fabric: Fabric) -> None:
        self._fabric = fabric
        self.sent = 0
        self.longest = 0.0

    async def run(self, seconds: float) -> None:
        loop = asyncio.get_running_loop()
        until_when = loop.time() + seconds
        while loop.time() < until_when:
            began = loop.time()
            self._fabric.publish("feed/a", self.sent.to_bytes(8, "big") + bytes(10_000))
            self.sent += 1
            self.longest = max(self.longest, loop.time() - began)
            await asyncio.sleep(0.005)


async def count_lines(process: Process) -> int:
    """Return the number of messages that a reader has printed; reads until it is quiet."""
    assert process.stdout is not None
    lines = 0
    with contextlib.suppress(TimeoutError):
        while True:
            async with asyncio.timeout(1.0):
                if not await process.stdout.readline():
                    break
            lines += 1
    return lines


async def test_sleeping_readers_neither_block_others_nor_fill_memory(router, seconds, figure):
    fabric = await Fabric.open(router.endpoint, router.credentials)
    async with contextlib.AsyncExitStack() as stack:
        healthy, slow, frozen = [
            await stack.enter_async_context(script(router, fabric_reader, pause)) for pause in ("0", "0.05", "0")
        ]
        assert router.pid is not None
        watched = {"router": router.pid, "slow reader": slow.pid, "publisher": os.getpid()}
        feed = Feed(fabric)
        await feed.run(0.5)  # the first growth of buffers does not count
        before = {name: memory(pid) for name, pid in watched.items()}
        frozen.send_signal(signal.SIGSTOP)
        counting = asyncio.create_task(count_lines(healthy))
        await feed.run(seconds)
        grown = {name: (memory(pid) - before[name]) / MB for name, pid in watched.items()}
        received = await counting
        slowly = await count_lines(slow)
        frozen.send_signal(signal.SIGCONT)
        thawed = await resumes(feed, frozen)
    figure("longest publication, ms", feed.longest * 1000.0)
    figure("received by the healthy reader", received / feed.sent)
    for name, megabytes in grown.items():
        figure(f"growth of the {name}, MB", megabytes)
    assert received > 0.5 * feed.sent
    assert 0 < slowly < received
    assert max(grown.values()) < 64.0, grown
    assert feed.longest < 1.0
    assert thawed
    await fabric.close()


async def resumes(feed: Feed, reader: Process) -> bool:
    """Return whether a reader that was frozen receives new publications."""
    assert reader.stdout is not None
    newest = feed.sent
    for _ in range(20):
        await feed.run(0.25)
        with contextlib.suppress(TimeoutError):
            while True:
                async with asyncio.timeout(0.1):
                    if int(await reader.stdout.readline()) >= newest:
                        return True
    return False


async def test_unauthorized_clients_are_refused_without_disturbing_others(router, tmp_path):
    fabric = await Fabric.open(router.endpoint, router.credentials)
    other = await Fabric.open(router.endpoint, router.credentials)
    received: list[bytes] = []
    fabric.subscribe("a", lambda key, payload: received.append(payload))
    first = router.pid
    for wrong in (
        RouterCredentials("agent", "guess"),
        RouterCredentials("", ""),
        RouterCredentials("x" * 5000, "y" * 5000),
    ):
        with pytest.raises(zenoh.ZError):
            await asyncio.to_thread(zenoh.open, client_config(router.endpoint, wrong))
    for noise in (b"", b"GET / HTTP/1.1\r\n\r\n", bytes(65536), os.urandom(65536)):
        _, writer = await asyncio.open_unix_connection(tmp_path / "run" / "router.sock")
        writer.write(noise)
        with contextlib.suppress(ConnectionError):
            await writer.drain()
        writer.close()

    def publish_and_look() -> bool:
        other.publish("a", b"still here")
        return bool(received)

    await until(publish_and_look)
    assert set(received) == {b"still here"}
    assert router.pid == first and router.restarts == 0
    await fabric.close()
    await other.close()


BURST = 2000
PAYLOAD = bytes(600)
"""Payload of the size of a position with its covariance."""

Publish = Callable[[str, bytes], None]


async def arrived(router: RouterProcess, reader: Fabric, key: str, publish: Publish) -> int:
    """Publish a burst; return the number of messages that arrive."""
    received = 0
    changed = asyncio.Event()

    def take(_key: str, payload: bytes) -> None:
        nonlocal received
        received += len(payload) == len(PAYLOAD)
        changed.set()

    subscription = reader.subscribe(key, take, limit=2 * BURST)
    async with patience(10):
        while not changed.is_set():  # until the router knows of the reader
            publish(key, b"x")
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(changed.wait(), 0.05)
    for _ in range(BURST):
        publish(key, PAYLOAD)
    with contextlib.suppress(TimeoutError):
        while received < BURST:  # or until nothing has come for a second
            changed.clear()
            await asyncio.wait_for(changed.wait(), 1.0)
    subscription.close()
    return received


async def test_a_burst_to_a_healthy_reader_arrives(tmp_path, figure: Figure) -> None:
    router = RouterProcess(tmp_path / "run")
    await router.start()
    reader, writer = [await Fabric.open(router.endpoint, router.credentials) for _ in range(2)]
    session = await asyncio.to_thread(zenoh.open, client_config(router.endpoint, router.credentials))

    def express(key: str, payload: bytes) -> None:
        session.put(key, payload, congestion_control=zenoh.CongestionControl.DROP, express=True)

    # Other processes of this host may delay the reader, but hardly in each attempt.
    wholes = [await arrived(router, reader, f"burst/batched-{attempt}", writer.publish) for attempt in range(3)]
    whole, singly = max(wholes), await arrived(router, reader, "burst/express", express)
    figure(f"of a burst of {BURST} arrived", str(whole))
    figure(f"of a burst of {BURST} arrived with express", str(singly))
    await asyncio.to_thread(session.close)
    for fabric in (reader, writer):
        await fabric.close()
    await router.close()
    assert whole > 0.9 * BURST
    assert whole > singly
