"""Drivers ``http:`` and ``https:``: lifts and doors behind a small JSON protocol.

``GET URL`` returns the state, ``POST URL`` takes an order; ``docs/lifts.md`` has the members of both.
"""

import asyncio
import ssl
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar
from urllib.parse import urlunsplit

import httpcore
import msgspec

from engine.devices.base import DeviceDriver, DeviceUrl, DoorDevice, LiftDevice
from engine.devices.hosts import DeviceHosts
from ppaas.buildings.building import DoorSettings, LiftSettings
from ppaas.buildings.doors.states import DoorMode, DoorRequest, DoorState
from ppaas.buildings.lifts.states import DoorPosition, EndSession, LiftMode, LiftRequest, LiftState, Motion
from ppaas.decoding import from_json
from ppaas.errors import Unavailable

TIMEOUT = 3.0
"""Time limit of a request, from the resolution of the name to the end of the answer [s]."""

POLL = 0.5
"""Time between two requests for the state [s], if the option ``poll`` does not set another."""

LARGEST = 64 << 10
"""Largest answer that is read [bytes]."""

S = TypeVar("S", bound=msgspec.Struct)


class _LiftAnswer(msgspec.Struct):
    """State of a lift, as a server returns it."""

    floor: str
    door: DoorPosition
    motion: Motion = "stopped"
    mode: LiftMode = "agv"
    session: str = ""
    floors: tuple[str, ...] = ()


class _DoorAnswer(msgspec.Struct):
    """State of a door, as a server returns it."""

    mode: DoorMode


class HttpDriver(DeviceDriver):
    """Driver of ``http:`` and ``https:``, with the option ``poll``: time between two requests for the state [s]."""

    def lift(
        self, url: DeviceUrl, settings: LiftSettings, levels: Mapping[str, float], hosts: DeviceHosts
    ) -> LiftDevice:
        """Return a lift behind an HTTP server."""
        return _HttpLift(url, settings.lift, _Server(url, hosts))

    def door(self, url: DeviceUrl, settings: DoorSettings, hosts: DeviceHosts) -> DoorDevice:
        """Return a door behind an HTTP server."""
        return _HttpDoor(settings, _Server(url, hosts))


class _ListedNetwork(httpcore.AsyncNetworkBackend):
    """Connects to hosts that the operator has listed, as they resolve at that moment."""

    def __init__(self, hosts: DeviceHosts) -> None:
        self._hosts = hosts
        self._network = httpcore.AnyIOBackend()

    async def connect_tcp(
        self,
        host: str,
        port: int,
        timeout: float | None = None,
        local_address: str | None = None,
        socket_options: Iterable[httpcore.SOCKET_OPTION] | None = None,
    ) -> httpcore.AsyncNetworkStream:
        address = await self._hosts.address(host, port)
        return await self._network.connect_tcp(address, port, timeout, local_address, socket_options)

    async def sleep(self, seconds: float) -> None:
        await self._network.sleep(seconds)


class _Server:
    """Server of a device; it follows no redirects."""

    def __init__(self, url: DeviceUrl, hosts: DeviceHosts) -> None:
        url.check_options("poll")
        self.poll = url.number("poll", POLL, 0.1, 2.0)
        host = f"[{url.host}]" if ":" in url.host else url.host
        netloc = host if url.port is None else f"{host}:{url.port}"
        self._url = urlunsplit((url.scheme, netloc, url.path or "/", "", ""))
        self._pool = httpcore.AsyncConnectionPool(
            ssl_context=ssl.create_default_context(), max_connections=2, network_backend=_ListedNetwork(hosts)
        )

    async def state(self, kind: type[S]) -> S:
        """Return the state; raise ``Unavailable`` if there is none."""
        body = await self._exchange("GET", None)
        try:
            return from_json(body, kind)
        except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
            raise Unavailable(f"{self._url} returned no state: {error!s:.200}") from error

    async def post(self, order: Mapping[str, Any]) -> None:
        """Send an order."""
        await self._exchange("POST", msgspec.json.encode(order))

    async def close(self) -> None:
        """Close the connections."""
        await self._pool.aclose()

    async def _exchange(self, method: str, content: bytes | None) -> bytes:
        headers = [("Content-Type", "application/json")] if content is not None else []
        try:
            async with (
                asyncio.timeout(TIMEOUT),
                self._pool.stream(method, self._url, headers=headers, content=content) as response,
            ):
                body = b""
                async for part in response.aiter_stream():
                    body += part
                    if len(body) > LARGEST:
                        raise Unavailable(f"{self._url} returned more than {LARGEST} bytes")
                if not 200 <= response.status < 300:
                    raise Unavailable(f"{self._url} answered {method} with {response.status}")
                return body
        except TimeoutError as error:
            raise Unavailable(f"{self._url} did not answer within {TIMEOUT:g} s") from error
        except (OSError, httpcore.NetworkError, httpcore.ProtocolError, httpcore.TimeoutException) as error:
            raise Unavailable(f"{self._url} did not answer: {error!s:.200}") from error


class _HttpLift(LiftDevice):
    def __init__(self, url: DeviceUrl, lift: str, server: _Server) -> None:
        self._url, self._lift, self._server = url, lift, server

    async def run(self, report: Callable[[LiftState], None]) -> None:
        try:
            while True:
                found = await self._server.state(_LiftAnswer)
                values = msgspec.structs.asdict(found)
                values["floor"] = self._url.ours(found.floor)
                values["floors"] = tuple(self._url.ours(floor) for floor in found.floors)
                report(LiftState(lift=self._lift, **values))
                await asyncio.sleep(self._server.poll)
        finally:
            await self._server.close()

    async def send(self, order: LiftRequest | EndSession) -> None:
        if isinstance(order, EndSession):
            await self._server.post({"session": order.session, "end": True})
        else:
            floor = self._url.theirs(order.floor)
            await self._server.post({"session": order.session, "floor": floor, "door": order.door})


class _HttpDoor(DoorDevice):
    def __init__(self, settings: DoorSettings, server: _Server) -> None:
        self._settings, self._server = settings, server

    async def run(self, report: Callable[[DoorState], None]) -> None:
        try:
            while True:
                found = await self._server.state(_DoorAnswer)
                report(DoorState(floor=self._settings.floor, door=self._settings.door, mode=found.mode))
                await asyncio.sleep(self._server.poll)
        finally:
            await self._server.close()

    async def send(self, order: DoorRequest) -> None:
        await self._server.post({"session": order.session, "mode": order.mode})
