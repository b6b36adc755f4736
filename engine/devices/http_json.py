"""Drivers ``http:`` and ``https:``: lifts and doors behind a small JSON protocol.

``GET URL`` returns the state, ``POST URL`` takes an order; ``docs/lifts.md`` has the members of both.
"""

import asyncio
import ssl
from collections.abc import Callable, Iterable, Mapping
from typing import Any
from urllib.parse import urlunsplit

import httpcore
import msgspec

from engine.devices.base import DeviceDriver, DeviceUrl, DoorDevice, LiftDevice
from engine.devices.hosts import DeviceHosts
from engine.devices.json_states import door_order, door_state_of, lift_order, lift_state_of
from ppaas.buildings.building import DoorSettings, LiftSettings
from ppaas.buildings.doors.states import DoorRequest, DoorState
from ppaas.buildings.lifts.states import EndSession, LiftRequest, LiftState
from ppaas.errors import MalformedMessage, Unavailable

TIMEOUT = 3.0
"""Time limit of a request, from the resolution of the name to the end of the answer [s]."""

POLL = 0.5
"""Time between two requests for the state [s], if the option ``poll`` does not set another."""

LARGEST = 64 << 10
"""Largest answer that is read [bytes]."""


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
        self._poll = url.number("poll", POLL, 0.1, 2.0)
        host = f"[{url.host}]" if ":" in url.host else url.host
        netloc = host if url.port is None else f"{host}:{url.port}"
        self._url = urlunsplit((url.scheme, netloc, url.path or "/", "", ""))
        self._pool = httpcore.AsyncConnectionPool(
            ssl_context=ssl.create_default_context(), max_connections=2, network_backend=_ListedNetwork(hosts)
        )

    async def poll_states(self, take: Callable[[bytes], None]) -> None:
        """Hand over the state again and again; raise ``Unavailable`` when there is none."""
        try:
            while True:
                take(await self._exchange("GET", None))
                await asyncio.sleep(self._poll)
        except MalformedMessage as error:
            raise Unavailable(f"{self._url} returned no state: {error}") from error
        finally:
            await self._pool.aclose()

    async def post(self, order: Mapping[str, Any]) -> None:
        """Send an order."""
        await self._exchange("POST", msgspec.json.encode(order))

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
        await self._server.poll_states(lambda body: report(lift_state_of(body, self._lift, self._url)))

    async def send(self, order: LiftRequest | EndSession) -> None:
        await self._server.post(lift_order(order, self._url))


class _HttpDoor(DoorDevice):
    def __init__(self, settings: DoorSettings, server: _Server) -> None:
        self._settings, self._server = settings, server

    async def run(self, report: Callable[[DoorState], None]) -> None:
        await self._server.poll_states(lambda body: report(door_state_of(body, self._settings)))

    async def send(self, order: DoorRequest) -> None:
        await self._server.post(door_order(order))
