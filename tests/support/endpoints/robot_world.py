"""Cloud on a real port, with a machine and containers played by the test."""

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest
from starlette.routing import WebSocketRoute
from starlette.websockets import WebSocket
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from endpoints.app import create_app
from endpoints.resources.services import Services
from endpoints.rosbridge import SessionRegistry, serve_robot_socket
from engine.control.master_driver import MasterDriver
from engine.control.robot_sessions import RobotSessions
from engine.master.balancers.first_fit import FirstFit
from engine.master.master import Master
from engine.specs.checkpoints import CheckpointSelection
from ppaas.wire.resumption import ID_HEADER, STATE_HEADER, TAKEN_HEADER
from tests.support.endpoints.serving import serve
from tests.support.engine.played_container import PlayedContainer, PlayingMachine
from tests.support.storage import records
from tests.support.waiting import patience

PASSWORD = "correct horse"
KEY = "robot:ann/tb1"


class World:
    """Cloud on a real port whose containers are played by the test."""

    def __init__(self, services: Services, service: MasterDriver, machine: PlayingMachine, token: str) -> None:
        self.services = services
        self.service = service
        self.machine = machine
        self.token = token
        self.sessions = RobotSessions(service, services.store, services.map_store, linger=0.0)
        self.clients = SessionRegistry(self.sessions, services.cloud.count_paths, linger=0.0)
        self.port = 0

    def linger(self, seconds: float) -> None:
        """Set the linger time of places and sessions [s]."""
        self.sessions._linger = self.clients._linger = seconds

    async def endpoint(self, websocket: WebSocket) -> None:
        await serve_robot_socket(websocket, self.services, self.clients)

    def url(self, role: str = "robot", robot: str = "tb1", **query: str) -> str:
        fields = {"role": role, "robot": robot, "token": self.token} | query
        return f"ws://127.0.0.1:{self.port}/?" + "&".join(f"{name}={value}" for name, value in fields.items())

    @asynccontextmanager
    async def connected(self, role: str = "robot", **query: str) -> AsyncIterator[ClientConnection]:
        """Connect a client to a robot that has a container."""
        async with connect(self.url(role, **query), open_timeout=10) as client:
            yield client

    @asynccontextmanager
    async def robot(self, **query: str) -> AsyncIterator[tuple[ClientConnection, PlayedContainer]]:
        """Connect a robot, and start its container."""
        connecting = asyncio.ensure_future(connect(self.url(**query), open_timeout=10))
        container = await self.machine.boot(await self.machine.started())
        async with await connecting as client:
            yield client, container
        await container.stream.close()


@asynccontextmanager
async def robot_world(folder: Path, services: Services) -> AsyncIterator[World]:
    """Run a cloud in which ann has the robot tb1."""
    await services.accounts.register("ann", PASSWORD)
    records.put_map(services.map_store, records.house())
    services.store.put_robot(records.robot("tb1", user="ann", map="house"))
    service = MasterDriver(
        Master(FirstFit(), services.cloud.quotas), CheckpointSelection(services.store), folder, "secret"
    )
    await service.start()
    machine = await PlayingMachine.join(folder)
    await service.wait_for_machine(10)
    made = World(services, service, machine, await services.accounts.login("ann", PASSWORD))
    app = create_app(services)
    app.router.routes.append(WebSocketRoute("/", made.endpoint))
    async with serve(app) as made.port:
        yield made
        await made.sessions.close()
        await service.close()
        await machine.leave()
    assert made.machine.away == 0
    assert made.clients._attachments == set()
    assert made.sessions._clients == {}
    assert not made.service.presence.is_here(KEY)


async def say(client: ClientConnection, **operation: Any) -> None:
    """Send a frame."""
    await client.send(json.dumps(operation))


async def hear(client: ClientConnection) -> dict[str, Any]:
    """Return the next frame."""
    async with patience(10):
        found: dict[str, Any] = json.loads(await client.recv())
        return found


async def closed(client: ClientConnection) -> tuple[int, str]:
    """Wait until the cloud closes a socket; return code and reason."""
    with pytest.raises(ConnectionClosed):
        async with patience(10):
            while True:
                await client.recv()
    assert client.close_code is not None
    assert client.close_reason is not None
    return client.close_code, client.close_reason


async def next_of(container: PlayedContainer, kind: type[Any]) -> Any:
    """Return the next frame of this kind that a container receives."""
    while not isinstance(frame := await container.next(), kind):
        assert frame is not None
    return frame


def session_headers(client: ClientConnection) -> tuple[str, str, int]:
    """Return the session headers of the handshake: state, id, number of frames received."""
    assert client.response is not None
    headers = client.response.headers
    return headers[STATE_HEADER], headers[ID_HEADER], int(headers[TAKEN_HEADER])


async def refusal(url: str) -> tuple[int, dict[str, Any]]:
    """Connect, expecting a refusal; return its status and problem."""
    with pytest.raises(InvalidStatus) as refused:
        await connect(url, open_timeout=10)
    response = refused.value.response
    assert response.headers["content-type"] == "application/problem+json"
    return response.status_code, json.loads(response.body or b"")
