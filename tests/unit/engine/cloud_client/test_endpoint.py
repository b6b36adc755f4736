"""An endpoint whose master is alive, and was outranked by another one."""

import asyncio
import math
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Protocol

import pytest

from engine.calls.caller import Caller, Frame
from engine.cloud_client import endpoint as module
from engine.cloud_client.endpoint import Endpoint, Here
from engine.cloud_client.master_link import OwnMaster
from engine.control.master_calls.interface import EndpointState, MasterCalls, Registration, RequestCounts
from engine.control.master_calls.server import EndpointServer
from engine.master.quotas import Quota
from engine.protocols.address import UnixAddress
from engine.protocols.framing import FrameStream
from engine.protocols.sockets import listen
from tests.support.endpoints.master_cloud import MasterCloud
from tests.support.engine.at_once import at_once
from tests.support.waiting import until

SECRET = "of the cloud"


class OtherLeader:
    """The lease as the endpoint reads it in the store."""

    def __init__(self) -> None:
        self.taken = False
        self.asked = 0

    async def __call__(self) -> bool:
        self.asked += 1
        return self.taken


@pytest.fixture
def cloud(short_path: Path) -> MasterCloud:
    return MasterCloud(short_path)


@pytest.fixture
async def server(short_path: Path, cloud: MasterCloud) -> AsyncIterator[EndpointServer]:
    made = EndpointServer(short_path / "e.sock", SECRET, cloud, None)  # type: ignore[arg-type]
    await made.start()
    yield made
    await made.close()


async def nobody(_user: str, _robot: str, _session: str | None) -> None:
    """Displace no socket."""


def endpoint_of(server: EndpointServer, lease: OtherLeader, folder: Path) -> Endpoint:
    master = OwnMaster(UnixAddress(server.path), SECRET, lease)
    here = Here("hall-1", "hall", folder, "http://h:8500")
    return Endpoint(here, master, Quota(), displace=nobody, load=lambda: (0, 0.0, RequestCounts()))


async def test_an_endpoint_ends_when_its_master_was_outranked(
    server: EndpointServer, cloud: MasterCloud, short_path: Path, monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:  # fmt: skip
    monkeypatch.setattr(module, "PERIOD", 0.02)
    monkeypatch.setattr(module, "SUCCESSION", 0.5)
    lease = OtherLeader()
    endpoint = endpoint_of(server, lease, short_path)
    await endpoint.start()
    running = asyncio.create_task(endpoint.run(30.0))
    await until(lambda: bool(at_once(server.endpoints.views())))
    await asyncio.sleep(0.2)
    assert not lease.asked, "its master leads"
    cloud.lead.is_lost = True
    await until(lambda: lease.asked > 2)
    assert not running.done(), "nobody else leads, as when the store fails"
    assert endpoint.cloud.master_silence < 10.0
    lease.taken = True
    await until(lambda: endpoint.cloud.master_silence == math.inf)
    assert not running.done(), "its clients are served until the other leader can"
    await asyncio.wait_for(running, 10.0)
    assert "another process leads this cloud now" in caplog.text
    await endpoint.close()


class Answered(Protocol):
    """Calls that the silent master takes."""

    register = MasterCalls.register
    report = MasterCalls.report


class SilentMaster:
    """Master that registers endpoints and then answers nothing, as one whose network is down."""

    def __init__(self) -> None:
        self.links = 0

    async def connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self.links += 1
        stream: FrameStream[Frame] = FrameStream(reader, writer, Frame)
        await Caller(stream, {Answered: self}).serve()
        await stream.close()

    async def register(self, registration: Registration) -> None:
        """Register an endpoint."""

    async def report(self, state: EndpointState) -> bool:
        """Answer never."""
        await asyncio.Event().wait()
        return True


@pytest.mark.parametrize("is_far", [True, False])
async def test_the_link_to_a_silent_master_is_closed_if_the_network_may_be_down(
    short_path: Path, monkeypatch: pytest.MonkeyPatch, is_far: bool
) -> None:
    monkeypatch.setattr(module, "PERIOD", 0.01)
    monkeypatch.setattr(module, "SILENCE", 0.01)
    monkeypatch.setattr(module, "GIVE_UP", 0.1)
    silent = SilentMaster()
    address = UnixAddress(short_path / "m.sock")
    listening = await listen(address, silent.connected)
    access = OwnMaster(address, SECRET, OtherLeader())
    monkeypatch.setattr(access, "is_far", is_far)
    here = Here("hall-1", "hall", short_path, "http://h:8500")
    endpoint = Endpoint(here, access, Quota(), displace=nobody, load=lambda: (0, 0.0, RequestCounts()))
    await endpoint.start()
    running = asyncio.create_task(endpoint.run(30.0))
    await until(lambda: silent.links == (2 if is_far else 1))
    await asyncio.sleep(0.3)
    assert (silent.links > 1) is is_far
    running.cancel()
    await asyncio.gather(running, return_exceptions=True)
    await endpoint.close()
    listening.close()
