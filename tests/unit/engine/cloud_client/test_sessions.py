"""Clients of an endpoint join their places again, once each, at every new master."""

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Protocol

import pytest

from engine.calls.caller import Caller, Frame
from engine.cloud_client import sessions as module
from engine.cloud_client.master_link import MasterLink, OwnMaster, undone_if_cancelled
from engine.cloud_client.sessions import EndpointPlaces, EndpointSessions
from engine.control.master_calls.interface import ClientJoin, JoinedPlace, MasterCalls, Registration
from engine.protocols.address import EndpointAddress, UnixAddress
from engine.protocols.framing import FrameStream
from engine.protocols.sockets import listen
from ppaas.errors import Conflict, Unavailable
from tests.support.engine.ignored_calls import IgnoredCalls
from tests.support.engine.listening import Listening
from tests.support.waiting import until

KEY = "robot:ada/tb1"


class Answered(Protocol):
    """Calls that the master takes."""

    register = MasterCalls.register
    join = MasterCalls.join
    leave = MasterCalls.leave


class Master:
    """Master that admits each robot once, or loses its endpoints as soon as they join."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.joins: list[ClientJoin] = []
        self.loses = False
        self.has_robot = False
        self._streams: list[FrameStream[Frame]] = []
        self._server: asyncio.Server | None = None

    async def start(self) -> None:
        """Listen as a new master, which has no clients."""
        self.joins.clear()
        self._server = await listen(UnixAddress(self.path), self._connected)

    async def end(self) -> None:
        """Close the socket and all links."""
        assert self._server is not None
        self._server.close()
        for stream in self._streams:
            await stream.close()
        self._streams.clear()
        self.path.unlink(missing_ok=True)

    async def _connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        stream: FrameStream[Frame] = FrameStream(reader, writer, Frame)
        self._streams.append(stream)
        await Caller(stream, {Answered: self}).serve()

    async def register(self, registration: Registration) -> None:
        """Register an endpoint."""

    async def leave(self, key: str, as_robot: bool) -> None:
        """Remove a client."""

    async def join(self, join: ClientJoin) -> JoinedPlace:
        """Add a client, or lose the endpoint."""
        self.joins.append(join)
        if self.loses:
            await asyncio.Event().wait()
        if join.as_robot and (self.has_robot or [one.as_robot for one in self.joins].count(True) > 1):
            raise Conflict("robot 'tb1' is connected already")
        return JoinedPlace(KEY, "base_link", None, "")


class AtEndpoint:
    """The sessions of an endpoint with the socket of a robot and an operator, and its link to the master."""

    def __init__(self, master: Master) -> None:
        access = OwnMaster(UnixAddress(master.path), "secret", nobody_else)
        self._places = EndpointPlaces()
        self._link = MasterLink(access, registration, IgnoredCalls(), self._found)
        self.sessions = EndpointSessions(self._link, self._places)
        self.client = Listening()
        self._running = asyncio.create_task(self._link.run())

    def _found(self) -> None:
        self.sessions.master_found()

    async def join(self) -> None:
        """Connect a robot and an operator."""
        for as_robot in (True, False):
            place = await self.sessions.join("ada", "tb1", as_robot=as_robot)
        place.join(self.client)

    async def end(self) -> None:
        """End the sessions and the link."""
        self._running.cancel()
        await asyncio.gather(self._running, return_exceptions=True)
        await self.sessions.close()


async def nobody_else() -> bool:
    """Return that no other process leads."""
    return False


def registration() -> Registration:
    """Return the first call of the endpoint."""
    return Registration("hall-1", "secret", "1", 1, EndpointAddress("hall", "unix:e"), "of containers", "http://h")


@pytest.fixture
async def master(short_path: Path) -> AsyncIterator[Master]:
    made = Master(short_path / "m.sock")
    await made.start()
    yield made
    await made.end()


@pytest.fixture
async def endpoint(master: Master) -> AsyncIterator[AtEndpoint]:
    made = AtEndpoint(master)
    await made.join()
    yield made
    await made.end()


async def test_clients_join_once_at_a_master_that_came_after_one_that_was_lost_meanwhile(
    master: Master, endpoint: AtEndpoint, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "RETRY", 0.05)
    await master.end()
    master.loses = True
    await master.start()
    await until(lambda: len(master.joins) == 2)
    await master.end()
    await asyncio.sleep(0.3)  # the clients would try again now, if there were a master
    master.loses = False
    await master.start()
    await until(lambda: len(master.joins) >= 2)
    await asyncio.sleep(0.3)
    assert sorted(join.as_robot for join in master.joins) == [False, True]
    assert endpoint.client.reasons == []


async def test_clients_of_a_robot_that_is_connected_elsewhere_now_may_connect_again(
    master: Master, endpoint: AtEndpoint
) -> None:
    await master.end()
    master.has_robot = True
    await master.start()
    await until(lambda: bool(endpoint.client.reasons))
    assert isinstance(endpoint.client.reasons[0], Unavailable)
    assert "is connected already" in str(endpoint.client.reasons[0])


async def test_the_result_of_a_caller_that_waits_is_kept() -> None:
    undone: list[int] = []
    assert await undone_if_cancelled(asyncio.sleep(0.0, 7), undone.append) == 7
    assert undone == []


async def test_the_result_is_undone_if_the_caller_is_cancelled() -> None:
    undone, may_end = list[int](), asyncio.Event()

    async def work() -> int:
        await may_end.wait()
        return 7

    waiting = asyncio.create_task(undone_if_cancelled(work(), undone.append))
    await asyncio.sleep(0.0)
    waiting.cancel()
    with pytest.raises(asyncio.CancelledError):
        await waiting
    assert undone == []
    may_end.set()
    await until(lambda: undone == [7])


async def test_work_that_fails_has_nothing_to_undo() -> None:
    async def work() -> int:
        raise Unavailable("no master")

    with pytest.raises(Unavailable, match="no master"):
        await undone_if_cancelled(work(), lambda _: pytest.fail("there is no result"))
