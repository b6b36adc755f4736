"""An endpoint registers with the master over a Unix socket, and is shown with its load while it is connected."""

import asyncio
import contextlib
from collections.abc import AsyncIterator, Callable
from contextlib import AsyncExitStack, asynccontextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from engine.calls.caller import Caller, Frame
from engine.calls.interface import method_of, remote
from engine.cloud_client.master_link import MasterLink, OwnMaster
from engine.control.counts import REQUEST_SECONDS
from engine.control.master_calls import server as module
from engine.control.master_calls.control_plane import MachineCalls, NeighbourCalls
from engine.control.master_calls.interface import (
    EndpointCalls,
    EndpointState,
    MasterCalls,
    Registration,
    ReportAnswer,
    RequestCounts,
)
from engine.control.master_calls.server import EndpointServer
from engine.control.views import EndpointView
from engine.protocols import handshakes
from engine.protocols.address import EndpointAddress, UnixAddress
from engine.protocols.framing import FrameStream
from engine.protocols.sockets import dial, listen
from engine.specs.start_state import READY, StartState
from ppaas import __version__
from ppaas.clock import ManualClock
from ppaas.errors import Conflict, NotPermitted, PPaaSError, Unavailable
from tests.support.endpoints.master_cloud import MasterCloud
from tests.support.engine.at_once import at_once
from tests.support.engine.ignored_calls import IgnoredCalls
from tests.support.waiting import until

SECRET = "of the cloud"


async def never() -> bool:
    """Return that no other process leads."""
    return False


def nothing() -> None:
    """Tell the master about no clients."""


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock(1000.0)


@pytest.fixture
def cloud(tmp_path: Path) -> MasterCloud:
    return MasterCloud(tmp_path)


@pytest.fixture
async def server(tmp_path: Path, clock: ManualClock, cloud: MasterCloud) -> AsyncIterator[EndpointServer]:
    made = EndpointServer(tmp_path / "e.sock", SECRET, cloud, None)  # type: ignore[arg-type]
    made.endpoints.clock = clock
    await made.start()
    yield made
    await made.close()


@asynccontextmanager
async def linked(server: EndpointServer, clock: Callable[[], float]) -> AsyncIterator[MasterLink]:
    url, release = "http://h:8500", __version__
    here = Registration("hall-1", SECRET, release, 77, EndpointAddress("hall", "unix:/e"), "own", url)
    access = OwnMaster(UnixAddress(server.path), SECRET, never)
    link = MasterLink(access, lambda: here, IgnoredCalls(), nothing, clock)  # type: ignore[arg-type]
    running = asyncio.create_task(link.run())
    try:
        yield link
    finally:
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)


async def test_an_endpoint_is_ready_while_it_reports_its_load(server: EndpointServer, clock: ManualClock) -> None:
    assert at_once(server.endpoints.views()) == []
    async with linked(server, clock) as link:
        await until(lambda: bool(at_once(server.endpoints.views())))
        known: dict[str, Any] = {"id": "hall-1", "machine": "hall", "pid": 77, "url": "http://h:8500"}
        known |= {"release": __version__}
        silent = EndpointView(**known, sockets=0, frames=0.0, cpu=0.0, memory=0, state="ready")
        assert at_once(server.endpoints.views()) == [silent]
        assert server.endpoints.requests() == {}
        answered = RequestCounts((0, 5, 0, 1, 0), [6] + [0] * len(REQUEST_SECONDS), 0.003)
        await link.call(MasterCalls.report, EndpointState(3, 60.0, 0.25, 90 << 20, answered))
        assert server.endpoints.requests() == {"hall-1": answered}
        ready = EndpointView(**known, sockets=3, frames=60.0, cpu=0.25, memory=90 << 20, state="ready")
        assert at_once(server.endpoints.views()) == [ready]
        clock.advance(2.6)
        assert [one.state for one in at_once(server.endpoints.views())] == ["silent"]
        await link.call(MasterCalls.report, EndpointState(3, 60.0, 0.25, 90 << 20))
        assert at_once(server.endpoints.views()) == [ready]
    await until(lambda: not at_once(server.endpoints.views()))


async def test_an_endpoint_learns_that_its_master_does_not_lead(
    server: EndpointServer, cloud: MasterCloud, clock: ManualClock
) -> None:
    async with linked(server, clock) as link:
        assert await link.call(MasterCalls.report, EndpointState(0, 0.0, 0.0, 0)) == ReportAnswer(
            leads=True, start=READY
        )
        cloud.lead.is_lost, cloud.start = True, StartState(ready=False)
        state = await link.call(MasterCalls.report, EndpointState(1, 0.0, 0.0, 0))
        assert state == ReportAnswer(leads=False, start=StartState(ready=False))
        assert [one.sockets for one in at_once(server.endpoints.views())] == [1], (
            "it is no frozen endpoint all the same"
        )


async def test_endpoints_are_read_over_the_link(server: EndpointServer, clock: ManualClock) -> None:
    async with linked(server, clock) as link:
        [seen] = await remote(NeighbourCalls, link).views()
        assert seen.id == "hall-1"


async def test_an_endpoint_knows_for_how_long_its_master_is_silent(server: EndpointServer, clock: ManualClock) -> None:
    async with linked(server, clock) as link:
        assert link.silence == float("inf")
        await until(lambda: link.silence == 0.0)
        clock.advance(4.0)
        assert link.silence == 4.0
        await link.call(MasterCalls.report, EndpointState(0, 0.0, 0.0, 0))
        assert link.silence == 0.0
        await server.close()
        clock.advance(20.0)
        assert link.silence == 20.0


@asynccontextmanager
async def stranger(server: EndpointServer) -> AsyncIterator[Caller]:
    """Connect without a registration."""
    stream: FrameStream[Frame] = FrameStream(*await dial(UnixAddress(server.path)), Frame)
    caller = Caller(stream, {EndpointCalls: IgnoredCalls()})
    serving = asyncio.create_task(caller.serve())
    try:
        yield caller
    finally:
        await stream.close()
        await asyncio.gather(serving, return_exceptions=True)


async def test_an_endpoint_may_call_nothing_before_it_has_registered(server: EndpointServer) -> None:
    async with stranger(server) as caller:
        for asked in (caller.call(MachineCalls.views), caller.call(MasterCalls.forget_place, "robot:ann/tb1")):
            with pytest.raises(NotPermitted, match="before it has registered"):
                await asked
    assert at_once(server.endpoints.views()) == []


async def test_silent_strangers_are_closed_in_time_and_make_room_before(
    server: EndpointServer, clock: ManualClock, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(handshakes, "MOST", 20)
    monkeypatch.setattr(module, "REGISTER_TIMEOUT", 60.0)
    async with contextlib.AsyncExitStack() as stack:
        served = await stack.enter_async_context(linked(server, clock))
        await until(lambda: bool(at_once(server.endpoints.views())))
        silent = [await dial(UnixAddress(server.path)) for _ in range(100)]
        for reader, _ in silent[:80]:
            assert await asyncio.wait_for(reader.read(), 10.0) == b""
        monkeypatch.setattr(module, "REGISTER_TIMEOUT", 0.05)
        late, _ = await dial(UnixAddress(server.path))
        assert await asyncio.wait_for(late.read(), 10.0) == b""
        await served.call(MasterCalls.report, EndpointState(0, 0.0, 0.0, 0))
        for _, writer in silent:
            writer.close()


@pytest.mark.parametrize(
    ("secret", "release", "expected"),
    [("guessed", __version__, NotPermitted), (SECRET, "0.0.9", Conflict)],
    ids=["secret", "release"],
)
async def test_endpoints_of_another_cloud_or_release_are_refused(
    server: EndpointServer, secret: str, release: str, expected: type[PPaaSError]
) -> None:
    async with stranger(server) as caller:
        with pytest.raises(expected):
            here = Registration("m-1", secret, release, 1, EndpointAddress("m", "unix:/e"), "s", "")
            await caller.call(MasterCalls.register, here)
        with pytest.raises(NotPermitted):
            await caller.call(MachineCalls.views)


def test_endpoints_of_every_release_register_by_the_same_name() -> None:
    """A master names the release of an endpoint that it refuses, so it must understand its first call."""
    assert method_of(MasterCalls.register).name == "register"


def registration(name: str = "hall-1", machine: str = "hall", advertised: str = "") -> Registration:
    """Return the registration of an endpoint of another host."""
    here = EndpointAddress(machine, "unix:/e", "tls://hall:7000", "f1")
    return Registration(name, "", __version__, 1, here, "s", "http://hall:8500", advertised)


@asynccontextmanager
async def machine_link(server: EndpointServer, folder: Path, machine: str = "hall") -> AsyncIterator[Caller]:
    """Connect as an endpoint whose certificate names a machine."""
    path = folder / f"{machine}.sock"
    listening = await listen(UnixAddress(path), partial(server.connected, machine=machine))
    stream: FrameStream[Frame] = FrameStream(*await dial(UnixAddress(path)), Frame)
    caller = Caller(stream, {EndpointCalls: IgnoredCalls()})
    serving = asyncio.create_task(caller.serve())
    try:
        yield caller
    finally:
        listening.close()
        await stream.close()
        await asyncio.gather(serving, return_exceptions=True)


@pytest.mark.parametrize(
    "lies", [registration(machine="loft"), registration("loft-1"), registration("hall-1-2"), registration("hall-x")]
)
async def test_an_endpoint_that_lies_about_its_machine_is_refused(
    server: EndpointServer, tmp_path: Path, lies: Registration
) -> None:
    async with machine_link(server, tmp_path) as caller:
        with pytest.raises(NotPermitted):
            await caller.call(MasterCalls.register, lies)
    assert at_once(server.endpoints.views()) == []


async def test_endpoints_of_a_removed_machine_are_cut_off_and_refused(server: EndpointServer, tmp_path: Path) -> None:
    cloud = server._cloud
    assert isinstance(cloud, MasterCloud)
    async with machine_link(server, tmp_path) as caller:
        await caller.call(MasterCalls.register, registration())
        cloud.master.removed.add("hall")
        await until(lambda: not at_once(server.endpoints.views()))
        with pytest.raises(Unavailable):
            await caller.call(MachineCalls.views)
    async with machine_link(server, tmp_path) as again:
        with pytest.raises(NotPermitted, match="removed"):
            await again.call(MasterCalls.register, registration())


async def test_an_endpoint_replaces_the_earlier_one_of_its_name(server: EndpointServer, tmp_path: Path) -> None:
    """Its earlier process may have died while the network was down, so that nobody told the master."""
    async with machine_link(server, tmp_path) as first, machine_link(server, tmp_path) as second:
        await first.call(MasterCalls.register, registration())
        await second.call(MasterCalls.register, registration())
        await until(lambda: len(at_once(server.endpoints.views())) == 1)
        await second.call(MasterCalls.report, EndpointState(2, 0.0, 0.0, 0))
        assert [one.sockets for one in at_once(server.endpoints.views())] == [2]


async def test_the_address_beside_a_container_is_that_of_the_endpoint_with_the_fewest_sockets(
    server: EndpointServer, tmp_path: Path
) -> None:
    names = {"hall-1": 5, "hall-2": 3, "hall-3": 1}
    async with AsyncExitStack() as stack:
        for name, sockets in names.items():
            caller = await stack.enter_async_context(machine_link(server, tmp_path))
            advertised = f"http://{name}" if name != "hall-3" else ""
            await caller.call(MasterCalls.register, registration(name, advertised=advertised))
            await caller.call(MasterCalls.report, EndpointState(sockets, 0.0, 0.0, 0))
        nearer = server.endpoints.nearer
        assert nearer(registration("local-1", "local"), "hall") == "http://hall-2"
        assert nearer(registration("local-1", "local"), "loft") == ""
        assert nearer(registration("local-1", "local"), None) == ""
        assert nearer(registration("hall-3"), "hall") == "", "it is there already"
