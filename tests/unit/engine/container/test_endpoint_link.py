"""The container's end of the robot link, when its endpoint exits and another starts."""

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import pytest

from engine.container.endpoint_link import EndpointLink
from engine.protocols import robot_link
from engine.protocols.framing import FrameStream
from tests.support.engine.engine_links import hello, pair, receive
from tests.support.waiting import patience

HELLO = hello("c1", "secret")


class Endpoints:
    """Endpoints that listen at one address, one after another."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._arrived: asyncio.Queue[FrameStream[Any]] = asyncio.Queue()

    async def listen(self) -> asyncio.Server:
        """Start another endpoint."""
        return await asyncio.start_unix_server(self._connected, self._path)

    async def _connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._arrived.put_nowait(FrameStream(reader, writer, robot_link.FromContainer))

    async def arrived(self) -> FrameStream[Any]:
        """Return the connection of the container, after it has dialled."""
        async with patience(10.0):
            return await self._arrived.get()


class Linked:
    """Container that has lost its endpoint, and without a notification dials after a minute only."""

    def __init__(self, endpoint: EndpointLink, endpoints: Endpoints) -> None:
        self.endpoint = endpoint
        self.endpoints = endpoints
        self.losses = 0

    def lost(self) -> None:
        """Count the lost connections."""
        self.losses += 1


@pytest.fixture
async def linked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Linked]:
    monkeypatch.setattr("engine.container.endpoint_link.RETRIES", (60.0,))
    near, far = await pair(robot_link.ToContainer, robot_link.FromContainer)
    made = Linked(EndpointLink(str(tmp_path / "link.sock"), near), Endpoints(tmp_path / "link.sock"))
    serving = asyncio.create_task(made.endpoint.serve(lambda _: True, lambda: HELLO, made.lost))
    await far.close()
    yield made
    serving.cancel()
    await asyncio.gather(serving, return_exceptions=True)
    await made.endpoint.close()


async def test_container_redials_when_notified_of_an_endpoint(linked: Linked) -> None:
    server = await linked.endpoints.listen()
    linked.endpoint.came()
    arrived = await linked.endpoints.arrived()
    assert await receive(arrived) == HELLO
    assert linked.endpoint.is_up and linked.losses == 1
    await arrived.close()
    linked.endpoint.came()
    again = await linked.endpoints.arrived()
    assert await receive(again) == HELLO
    assert linked.losses == 2
    await again.close()
    server.close()


async def test_container_keeps_waiting_if_the_endpoint_does_not_answer(linked: Linked) -> None:
    linked.endpoint.came()
    while linked.endpoint._came.is_set():
        await asyncio.sleep(0)
    assert not linked.endpoint.is_up
    server = await linked.endpoints.listen()
    linked.endpoint.came()
    arrived = await linked.endpoints.arrived()
    assert await receive(arrived) == HELLO
    await arrived.close()
    server.close()
