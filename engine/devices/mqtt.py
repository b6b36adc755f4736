"""Drivers ``mqtt:`` and ``mqtts:``: lifts and doors behind an MQTT broker; ``docs/lifts.md`` has topics and members.

Each device has a connection to its broker, and two topics below the path of its URL: ``state`` and ``order``.
"""

import itertools
import os
import ssl
from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from typing import Any, ClassVar
from urllib.parse import unquote

import msgspec

from engine.devices.base import DeviceDriver, DeviceUrl, DoorDevice, LiftDevice
from engine.devices.hosts import DeviceHosts
from engine.devices.json_states import door_order, door_state_of, lift_order, lift_state_of
from ppaas.buildings.building import DoorSettings, LiftSettings
from ppaas.buildings.doors.states import DoorRequest, DoorState
from ppaas.buildings.lifts.states import EndSession, LiftRequest, LiftState
from ppaas.clock import epoch
from ppaas.distribution import install_hint
from ppaas.errors import InvalidInput, Unavailable

PORTS = {"mqtt": 1883, "mqtts": 8883}

PASSWORD = "PPAAS_MQTT_PASSWORD"
"""Environment variable with the password of the user in the URL."""

TIMEOUT = 5.0
"""Time limit of a connection, a subscription or an order that the broker confirms [s]."""

KEEP_ALIVE = 10
"""Time without messages after which the client pings [s]."""


class MqttDriver(DeviceDriver):
    """Driver of ``mqtt://[USER@]HOST[:PORT]/PREFIX``, and ``mqtts:`` with TLS."""

    extra: ClassVar[str | None] = "devices"

    def lift(
        self, url: DeviceUrl, settings: LiftSettings, levels: Mapping[str, float], hosts: DeviceHosts
    ) -> LiftDevice:
        """Return a lift behind a broker."""
        return _MqttLift(url, settings.lift, _Topics(url, hosts))

    def door(self, url: DeviceUrl, settings: DoorSettings, hosts: DeviceHosts) -> DoorDevice:
        """Return a door behind a broker."""
        return _MqttDoor(settings, _Topics(url, hosts))


class _Topics:
    """The two topics of a device."""

    def __init__(self, url: DeviceUrl, hosts: DeviceHosts) -> None:
        url.check_options()
        prefix = unquote(url.path.strip("/"))
        if not prefix or set(prefix) & {"+", "#", "\0"}:
            raise InvalidInput("the path of a device of mqtt: is the beginning of its topics, such as /site/lifts/A")
        self._state, self._order = f"{prefix}/state", f"{prefix}/order"
        self._url, self._hosts = url, hosts
        self._library = _imported()
        self._numbers = itertools.count(1)
        self._client: Any = None

    async def follow(self, take: Callable[[bytes], None]) -> None:
        """Hand over states as they come; a retained one is left out, for it may be old.

        Raises
        ------
        Unavailable
            The broker cannot be reached, or not any more.
        """
        url, port = self._url, self._url.port or PORTS[self._url.scheme]
        host = await self._hosts.address(url.host, port)
        tls = ssl.create_default_context() if url.scheme == "mqtts" else None
        try:
            async with self._library.Client(
                host,
                port,
                username=unquote(url.user) or None,
                password=os.environ.get(PASSWORD) if url.user else None,
                timeout=TIMEOUT,
                keepalive=KEEP_ALIVE,
                tls_context=tls,
            ) as client:
                await client.subscribe(self._state, qos=0)
                self._client = client
                async for message in client.messages:
                    if not message.retain:
                        take(bytes(message.payload))
        except self._library.MqttError as error:
            raise Unavailable(f"the broker {url.host}:{port} cannot be used: {error}") from error
        finally:
            self._client = None

    async def publish(self, order: Mapping[str, Any]) -> None:
        """Publish an order, with the header that messages of VDA 5050 have."""
        if self._client is None:
            raise Unavailable(f"the broker {self._url.host} is not connected")
        stamp = datetime.fromtimestamp(epoch(), UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
        body = msgspec.json.encode({"headerId": next(self._numbers), "timestamp": stamp, **order})
        try:
            await self._client.publish(self._order, body, qos=1)
        except self._library.MqttError as error:
            raise Unavailable(f"the broker {self._url.host} did not take an order: {error}") from error


class _MqttLift(LiftDevice):
    def __init__(self, url: DeviceUrl, lift: str, topics: _Topics) -> None:
        self._url, self._lift, self._topics = url, lift, topics

    async def run(self, report: Callable[[LiftState], None]) -> None:
        await self._topics.follow(lambda body: report(lift_state_of(body, self._lift, self._url)))

    async def send(self, order: LiftRequest | EndSession) -> None:
        await self._topics.publish(lift_order(order, self._url))


class _MqttDoor(DoorDevice):
    def __init__(self, settings: DoorSettings, topics: _Topics) -> None:
        self._settings, self._topics = settings, topics

    async def run(self, report: Callable[[DoorState], None]) -> None:
        await self._topics.follow(lambda body: report(door_state_of(body, self._settings)))

    async def send(self, order: DoorRequest) -> None:
        await self._topics.publish(door_order(order))


def _imported() -> Any:
    try:
        import aiomqtt  # noqa: PLC0415 - of the extra devices
    except ImportError as error:
        raise InvalidInput(f"devices of mqtt: need the extra devices: {install_hint('devices')}") from error
    return aiomqtt
