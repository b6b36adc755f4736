"""WebSocket of a viewer: who may connect, and how a connection ends."""

import asyncio
import base64
import json
from collections.abc import AsyncIterator

import httpx
import pytest
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.typing import Origin, Subprotocol

from endpoints.audit.event import AuditQuery
from endpoints.foxglove import app
from endpoints.foxglove.app import SUBPROTOCOLS, BatchingConnection, foxglove_app
from endpoints.http.front_settings import FrontSettings
from endpoints.resources.services import Services
from tests.support.endpoints.rapyuta import StillSessions
from tests.support.endpoints.serving import serve
from tests.support.waiting import PATIENCE, until

OFFERED = [Subprotocol(one) for one in SUBPROTOCOLS]


class Port:
    """Port for viewers, and a token of ann."""

    def __init__(self, services: Services, number: int, token: str) -> None:
        self.services = services
        self.address = f"127.0.0.1:{number}"
        self.token = token

    def url(self, query: str = "") -> str:
        return f"ws://{self.address}/?token={self.token}{query}"

    async def refusal(self, url: str) -> tuple[str, int, str]:
        """Connect, expecting a refusal; return the status that the user is shown, the close code and its reason."""
        async with connect(url, subprotocols=OFFERED) as socket:
            status = json.loads(await socket.recv())
            with pytest.raises(ConnectionClosed) as closed:
                await socket.recv()
        assert (status["op"], status["level"]) == ("status", 2)
        assert closed.value.rcvd is not None
        return status["message"], closed.value.rcvd.code, closed.value.rcvd.reason


@pytest.fixture
async def port(services: Services, sessions: StillSessions, token: str) -> AsyncIterator[Port]:
    text = await services.accounts.login("ann", "correct horse")
    async with serve(foxglove_app(services, sessions, FrontSettings())) as number:  # type: ignore[arg-type]
        yield Port(services, number, text)
    assert not sessions.attached


async def _first(socket: ClientConnection) -> dict[str, object]:
    found: dict[str, object] = json.loads(await socket.recv())
    return found


@pytest.mark.parametrize("subprotocol", OFFERED)
async def test_both_subprotocols_are_spoken(port: Port, subprotocol: Subprotocol, sessions: StillSessions) -> None:
    origin = Origin("https://app.foxglove.dev")
    async with connect(port.url(), subprotocols=[subprotocol], origin=origin) as socket:
        assert socket.subprotocol == subprotocol
        assert (await _first(socket))["op"] == "serverInfo"
        channels = {channel["topic"] for channel in (await _first(socket))["channels"]}  # type: ignore[attr-defined]
        assert "/tb1/scan" in channels
        assert sessions.attached
    await until(lambda: not sessions.attached)


async def test_a_viewer_without_a_right_is_told_so(port: Port) -> None:
    text, code, reason = await port.refusal(f"ws://{port.address}/?token=guess")
    assert text.startswith("not-authenticated: the token is unknown or expired")
    assert (code, reason) == (1008, text)
    [event, *_] = port.services.audit.read(AuditQuery(outcome="refused"))
    assert (event.action, event.status, event.details["protocol"], event.user) == ("connect", 401, "foxglove", None)
    text, code, _ = await port.refusal(port.url("&robot=a/b"))
    assert (text, code) == ("invalid-parameter: robot must be ID or OWNER:ID, not 'a/b'", 1011)
    text, _, _ = await port.refusal(port.url("&robot=tb1" * 51))
    assert text == "invalid-parameter: name at most 50 robots, or none to see all"


async def test_a_page_of_another_host_needs_a_token(port: Port) -> None:
    basic = {"Authorization": "Basic " + base64.b64encode(f"ann:{port.token}".encode()).decode()}
    address, page = f"ws://{port.address}/", Origin("https://pages.example")
    async with connect(address, subprotocols=OFFERED, additional_headers=basic) as socket:
        assert (await _first(socket))["op"] == "serverInfo"
    async with connect(address, subprotocols=OFFERED, additional_headers=basic, origin=page) as socket:
        assert (await _first(socket))["message"].startswith("not-permitted: pages of other hosts")  # type: ignore[attr-defined]


async def test_a_client_of_another_protocol_gets_a_problem(port: Port) -> None:
    with pytest.raises(InvalidStatus) as refused:
        await connect(port.url())
    assert refused.value.response.status_code == 422
    assert "offer the subprotocol foxglove.sdk.v1" in (refused.value.response.body or b"").decode()
    async with httpx.AsyncClient(timeout=PATIENCE) as client:
        page = await client.get(f"http://{port.address}/")
    assert f"ws://{port.address}/?token=TOKEN" in page.text


async def test_a_user_has_few_viewers(port: Port, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(app, "MAX_OF_USER", 1)
    async with connect(port.url(), subprotocols=OFFERED):
        text, code, _ = await port.refusal(port.url())
        assert (text.partition(":")[0], code) == ("quota-exceeded", 1011)
    while True:
        async with connect(port.url(), subprotocols=OFFERED) as socket:
            if (await _first(socket))["op"] == "serverInfo":
                break


async def test_a_viewer_whose_token_ends_is_disconnected(port: Port, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("endpoints.foxglove.viewer.PERIOD", 0.05)
    async with connect(port.url(), subprotocols=OFFERED) as socket:
        await _first(socket)
        await port.services.accounts.revoke_all("ann")
        with pytest.raises(ConnectionClosed) as closed:
            while True:
                await socket.recv()
    assert closed.value.rcvd is not None
    assert closed.value.rcvd.code == 1008


class FakeConnection:
    """Connection that notes what each write consists of."""

    def __init__(self) -> None:
        self.ready = True
        self.writes: list[list[bytes]] = []

    def send_frames(self, frames: list[bytes]) -> None:
        self.writes.append(frames)


async def test_frames_wait_for_each_other() -> None:
    connection = FakeConnection()
    sink = BatchingConnection(connection)  # type: ignore[arg-type]
    for number in range(3):
        sink.send_frame(b"%d" % number)
    assert not connection.writes
    await asyncio.sleep(3 * app.PERIOD)
    assert connection.writes == [[b"0", b"1", b"2"]]


async def test_many_bytes_are_sent_at_once() -> None:
    connection = FakeConnection()
    sink = BatchingConnection(connection)  # type: ignore[arg-type]
    sink.send_frame(b"a")
    sink.send_frame(bytes(app.MAX_WAITING))
    assert [len(frames) for frames in connection.writes] == [2]
    await asyncio.sleep(3 * app.PERIOD)
    assert len(connection.writes) == 1


async def test_nothing_is_sent_to_a_closed_connection() -> None:
    connection = FakeConnection()
    sink = BatchingConnection(connection)  # type: ignore[arg-type]
    sink.send_frame(b"a")
    connection.ready = False
    sink.flush()
    assert not connection.writes
