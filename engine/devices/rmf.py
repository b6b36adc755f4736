"""Driver ``rmf:``: lifts and doors with a driver for Open-RMF, over Zenoh as rmw_zenoh speaks it; no ROS.

Messages are ``rmf_lift_msgs`` and ``rmf_door_msgs``. Open-RMF has no rule by which a lift or a door ends a session
without requests: whether it does is up to its driver there.
"""

import asyncio
import itertools
import json
from collections.abc import Callable, Mapping
from typing import Any, ClassVar
from urllib.parse import unquote

from engine.devices.base import DeviceDriver, DeviceUrl, DoorDevice, LiftDevice
from engine.devices.hosts import DeviceHosts
from ppaas.buildings.building import DoorSettings, LiftSettings
from ppaas.buildings.doors.states import DOOR_MODES, DoorRequest, DoorState
from ppaas.buildings.lifts.states import DoorPosition, EndSession, LiftMode, LiftRequest, LiftState, Motion
from ppaas.clock import epoch
from ppaas.distribution import install_hint
from ppaas.errors import InvalidInput, MalformedMessage, Unavailable
from ppaas.wire.ros import ros_types
from ppaas.wire.ros.graph import ROS_2_RELEASES, Entity, Kind, Qos
from ppaas.wire.ros.rmf_definitions import DOOR_REQUEST, DOOR_STATE, LIFT_REQUEST, LIFT_STATE
from ppaas.wire.ros.rmw_zenoh import ZenohNode, gid_of, pack_attachment, topic_key

PORT = 7447

DOORS: tuple[DoorPosition, ...] = ("closed", "moving", "open")

MOTIONS: tuple[Motion, ...] = ("stopped", "up", "down")

LIFT_MODES: tuple[LiftMode, ...] = ("unknown", "human", "agv", "fire", "offline", "emergency")

END_SESSION, AGV_MODE = 0, 1

OPEN = 2
"""Number of open doors, in states and requests."""

CHECK = 1.0
"""Time between two looks at the connection [s]."""


class RmfDriver(DeviceDriver):
    """Driver of ``rmf://HOST[:PORT]/NAME``: the router of Zenoh, and the name of the lift or door in Open-RMF.

    Options are ``domain`` (of ROS), ``release`` (of ROS) and ``requests``: topic of requests, such as
    ``adapter_lift_requests`` where a supervisor of Open-RMF runs.
    """

    extra: ClassVar[str | None] = "ros2"

    def lift(
        self, url: DeviceUrl, settings: LiftSettings, levels: Mapping[str, float], hosts: DeviceHosts
    ) -> LiftDevice:
        """Return a lift of Open-RMF."""
        return _RmfLift(url, settings.lift, _Node(url, hosts, ("lift_requests", LIFT_REQUEST)))

    def door(self, url: DeviceUrl, settings: DoorSettings, hosts: DeviceHosts) -> DoorDevice:
        """Return a door of Open-RMF."""
        return _RmfDoor(settings, _Node(url, hosts, ("door_requests", DOOR_REQUEST)))


class _Node:
    """Node of ROS that subscribes to states, and publishes requests."""

    def __init__(self, url: DeviceUrl, hosts: DeviceHosts, requests: tuple[str, str]) -> None:
        url.check_options("domain", "release", "requests")
        self.name = unquote(url.path.strip("/"))
        if not self.name:
            raise InvalidInput("the path of a device of rmf: is its name in Open-RMF, such as rmf://10.0.0.7/lift1")
        release = url.options.get("release", "jazzy")
        if release not in ROS_2_RELEASES:
            raise InvalidInput(f"unknown release of ROS {release!r}; known: {', '.join(ROS_2_RELEASES)}")
        self._domain = int(url.number("domain", 0, 0, 232))
        self._topic, self._type = url.options.get("requests", requests[0]).strip("/"), requests[1]
        self._url, self._hosts = url, hosts
        self._zenoh = _imported()
        self._types = ros_types(release)
        self._numbers = itertools.count(1)
        self._publish: Callable[[bytes], None] | None = None

    async def follow(self, topic: str, type_name: str, take: Callable[[dict[str, Any]], None]) -> None:
        """Hand over states until the connection to the router is lost.

        Raises
        ------
        Unavailable
            The router cannot be reached, or not any more.
        """
        url, port = self._url, self._url.port or PORT
        host = await self._hosts.address(url.host, port)
        name = f"tcp/[{host}]:{port}" if ":" in host else f"tcp/{host}:{port}"
        loop = asyncio.get_running_loop()
        try:
            session = await asyncio.to_thread(self._zenoh.open, self._config(name))
        except self._zenoh.ZError as error:
            raise Unavailable(f"the router {name} cannot be reached: {error}") from error

        def received(sample: Any) -> None:
            if not loop.is_closed():
                loop.call_soon_threadsafe(self._decode, type_name, sample.payload.to_bytes(), take)

        try:
            kept = self._declare(session, topic, type_name, received)
            while any(True for _ in session.info.routers_zid()):  # noqa: ASYNC110 - Zenoh reports no loss
                await asyncio.sleep(CHECK)
            del kept
            raise Unavailable(f"the router {name} is lost")
        finally:
            self._publish = None
            await asyncio.to_thread(session.close)

    def _decode(self, type_name: str, data: bytes, take: Callable[[dict[str, Any]], None]) -> None:
        try:
            take(self._types.decode(type_name, data))
        except MalformedMessage:
            return  # of another node: the lift counts as silent if its own are not valid

    def _declare(self, session: Any, topic: str, type_name: str, received: Callable[[Any], None]) -> list[Any]:
        """Declare the node, a subscriber and a publisher; they end when they are not referenced."""
        node = ZenohNode(self._domain, str(session.info.zid()), "/", "ppaas_building")
        liveliness = session.liveliness()
        tokens = [node.token]
        entities = ((Kind.SUBSCRIBER, topic, type_name), (Kind.PUBLISHER, self._topic, self._type))
        for number, (kind, name, of_type) in enumerate(entities, start=1):
            entity = Entity(kind, f"/{name}", of_type, Qos(), "/ppaas_building", "", self._types.type_hash(of_type))
            tokens.append(node.entity_token(number, entity))
        gid = gid_of(tokens[-1])
        key = topic_key(self._domain, self._topic, self._type, self._types.type_hash(self._type))
        publisher = session.declare_publisher(key)
        subscriber = session.declare_subscriber(topic_key(self._domain, topic, type_name), received)

        def publish(data: bytes) -> None:
            publisher.put(data, attachment=pack_attachment(next(self._numbers), int(epoch() * 1e9), gid))

        self._publish = publish
        return [subscriber, publisher, *(liveliness.declare_token(token) for token in tokens)]

    def send(self, message: Mapping[str, Any]) -> None:
        """Publish a request."""
        if self._publish is None:
            raise Unavailable(f"the router {self._url.host} is not connected")
        self._publish(self._types.encode(self._type, message))

    def _config(self, endpoint: str) -> Any:
        config = self._zenoh.Config()
        settings = {"mode": "client", "connect/endpoints": [endpoint], "scouting/multicast/enabled": False}
        for key, value in settings.items():
            config.insert_json5(key, json.dumps(value))
        return config


class _RmfLift(LiftDevice):
    def __init__(self, url: DeviceUrl, lift: str, node: _Node) -> None:
        self._url, self._lift, self._node = url, lift, node

    async def run(self, report: Callable[[LiftState], None]) -> None:
        def take(message: dict[str, Any]) -> None:
            if message["lift_name"] == self._node.name:
                report(self._state(message))

        await self._node.follow("lift_states", LIFT_STATE, take)

    def _state(self, message: Mapping[str, Any]) -> LiftState:
        return LiftState(
            lift=self._lift,
            floor=self._url.ours(message["current_floor"]),
            door=_at(DOORS, message["door_state"], "moving"),
            # The number behind "down" is "unknown": nobody boards a car that may move.
            motion=_at(MOTIONS, message["motion_state"], "up"),
            mode=_at(LIFT_MODES, message["current_mode"], "unknown"),
            session=message["session_id"],
            floors=tuple(self._url.ours(floor) for floor in message["available_floors"]),
        )

    async def send(self, order: LiftRequest | EndSession) -> None:
        is_end = isinstance(order, EndSession)
        self._node.send(
            {
                "lift_name": self._node.name,
                "request_time": _time(),
                "session_id": order.session,
                "request_type": END_SESSION if is_end else AGV_MODE,
                "destination_floor": "" if isinstance(order, EndSession) else self._url.theirs(order.floor),
                "door_state": 0 if is_end else OPEN,
            }
        )


class _RmfDoor(DoorDevice):
    def __init__(self, settings: DoorSettings, node: _Node) -> None:
        self._settings, self._node = settings, node

    async def run(self, report: Callable[[DoorState], None]) -> None:
        def take(message: dict[str, Any]) -> None:
            if message["door_name"] == self._node.name:
                mode = _at(DOOR_MODES, message["current_mode"]["value"], "unknown")
                report(DoorState(floor=self._settings.floor, door=self._settings.door, mode=mode))

        await self._node.follow("door_states", DOOR_STATE, take)

    async def send(self, order: DoorRequest) -> None:
        self._node.send(
            {
                "request_time": _time(),
                "requester_id": order.session,
                "door_name": self._node.name,
                "requested_mode": {"value": OPEN if order.mode == "open" else 0},
            }
        )


def _at(names: tuple[Any, ...], number: int, other: Any) -> Any:
    return names[number] if number < len(names) else other


def _time() -> dict[str, int]:
    seconds, rest = divmod(epoch(), 1.0)
    return {"sec": int(seconds), "nanosec": int(rest * 1e9)}


def _imported() -> Any:
    try:
        import xxhash  # noqa: F401, PLC0415 - of identities in the graph
        import zenoh  # noqa: PLC0415 - of the extra ros2
    except ImportError as error:
        raise InvalidInput(f"devices of rmf: need the extra ros2: {install_hint('ros2')}") from error
    return zenoh
