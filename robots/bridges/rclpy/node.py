"""Node of ROS 2 on rclpy, where the robot has ROS anyway: any RMW, with services and actions.

Messages pass as bytes: rclpy publishes and delivers serialized messages. An executor of rclpy spins in a separate
thread; everything else is on the event loop.
"""

import asyncio
import os
import threading
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from ppaas.errors import InvalidInput, Unavailable, UnknownType
from ppaas.wire.ros import ros_types
from ppaas.wire.ros.graph import Entity, Kind, Qos
from ppaas.wire.ros.types import RELEASES
from robots.bridges.core.notices import Notices
from robots.bridges.core.transport import Answer, Closable, Publisher, Received, Transport

DEFAULT_RELEASE = "jazzy"

POLL = 0.5
"""Time between two looks at the graph [s]."""

SUPER_CLIENT = "ROS_SUPER_CLIENT", "TRUE"
"""Variable by which a discovery server of Fast DDS, if there is one, sends the whole graph, not only what matches."""

SPIN = 0.2
"""Longest time that the thread spins before it checks whether the transport is closed [s]."""

FEEDBACK, SEND_GOAL, GET_RESULT = "FeedbackMessage", "SendGoal", "GetResult"
_PARTS = {FEEDBACK: FEEDBACK, SEND_GOAL: "SendGoalService", GET_RESULT: "GetResultService"}
"""Names of the types of an action within its class, by the end of their names in ROS."""


@dataclass(frozen=True, slots=True)
class RclpyOptions:
    """Options of rclpy: domain of ROS, and its release; empty for ``ROS_DISTRO``."""

    domain: int = 0
    release: str = ""


class _Entity:
    def __init__(self, close: Callable[[], object]) -> None:
        self._close = close

    def close(self) -> None:
        self._close()


class _Publisher(_Entity):
    def __init__(self, close: Callable[[], object], publish: Callable[[bytes], None]) -> None:
        super().__init__(close)
        self.publish = publish


class RclpyTransport(Transport):
    """Transport over rclpy.

    Parameters
    ----------
    options : RclpyOptions
        Domain and release.
    name : str
        Name of the node.
    """

    def __init__(self, options: RclpyOptions, name: str = "ppaas_bridge") -> None:
        self._options, self._name, self.domain = options, name, options.domain
        self._rclpy = _imported()
        self._notices = Notices()
        self._entities: tuple[Entity, ...] = ()
        self._closing = threading.Event()
        self._thread: threading.Thread | None = None
        self._poller: asyncio.Task[None] | None = None

    async def open(self, changed: Callable[[], None]) -> None:
        """Start the node."""
        self._loop, self._changed = asyncio.get_running_loop(), changed
        os.environ.setdefault(*SUPER_CLIENT)
        try:
            self._context = self._rclpy.Context()
            self._rclpy.init(context=self._context, domain_id=self._options.domain)
            self._node = self._rclpy.create_node(self._name, context=self._context)
        except Exception as error:
            raise Unavailable(f"rclpy cannot be opened in domain {self._options.domain}: {error}") from error
        release = self._options.release or os.environ.get("ROS_DISTRO", "")
        self.types = ros_types(release if release in RELEASES else DEFAULT_RELEASE)
        self._notices.info(f"types of messages are those of ROS 2 {self.types.release}")
        self._executor = import_module("rclpy.executors").SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._thread = threading.Thread(target=self._spin, name="rclpy", daemon=True)
        self._thread.start()
        self._poller = asyncio.create_task(self._watch())

    async def close(self) -> None:
        """End the node."""
        if self._poller is not None:
            self._poller.cancel()
            await asyncio.gather(self._poller, return_exceptions=True)
        self._closing.set()
        if self._thread is not None:
            await asyncio.to_thread(self._thread.join)
            self._node.destroy_node()
            self._rclpy.shutdown(context=self._context)

    def _spin(self) -> None:
        while not self._closing.is_set():
            self._executor.spin_once(timeout_sec=SPIN)

    def _post(self, call: Callable[..., object], *arguments: Any) -> None:
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(call, *arguments)

    # -- graph ---------------------------------------------------------------------------------------------------------

    def entities(self) -> tuple[Entity, ...]:
        """Return the publishers and subscribers of the other nodes."""
        return self._entities

    async def _watch(self) -> None:
        while True:
            found = await asyncio.to_thread(self._look)
            if found != self._entities:
                self._entities = found
                self._changed()
            await asyncio.sleep(POLL)

    def _look(self) -> tuple[Entity, ...]:
        found = []
        for topic, _ in self._node.get_topic_names_and_types():
            for kind, infos in (
                (Kind.PUBLISHER, self._node.get_publishers_info_by_topic(topic)),
                (Kind.SUBSCRIBER, self._node.get_subscriptions_info_by_topic(topic)),
            ):
                found += [_entity(kind, topic, info) for info in infos if info.node_name != self._name]
        return tuple(sorted(found, key=lambda entity: entity.id))

    # -- topics --------------------------------------------------------------------------------------------------------

    def has_type(self, name: str) -> bool:
        """Return whether the robot's ROS has the package of a type."""
        try:
            self._type(name)
        except UnknownType:
            return False
        return True

    def publisher(self, topic: str, type_name: str, qos: Qos) -> Publisher:
        """Return a publisher."""
        created = self._node.create_publisher(self._type(type_name), topic, self._qos(qos))
        return _Publisher(lambda: self._node.destroy_publisher(created), created.publish)

    def subscribe(self, topic: str, type_name: str, qos: Qos, received: Received) -> Closable:
        """Subscribe to a topic."""
        created = self._node.create_subscription(
            self._type(type_name), topic, lambda data: self._post(received, bytes(data)), self._qos(qos), raw=True
        )
        self._executor.wake()
        return _Entity(lambda: self._node.destroy_subscription(created))

    def serve(self, service: str, type_name: str, answer: Answer) -> Closable:
        """Serve a service. The callback waits in rclpy's way, so that other callbacks run meanwhile."""
        kind = self._type(type_name)
        serialization = import_module("rclpy.serialization")
        future_type = import_module("rclpy.task").Future

        async def callback(request: Any, response: Any) -> Any:
            waiting = future_type(executor=self._executor)
            self._post(self._answer, answer, serialization.serialize_message(request), waiting)
            data = await waiting
            return response if data is None else serialization.deserialize_message(data, kind.Response)

        # A callback that waits would block all others of its group, unless the group is reentrant.
        group = import_module("rclpy.callback_groups").ReentrantCallbackGroup()
        created = self._node.create_service(kind, service, callback, callback_group=group)
        self._executor.wake()
        return _Entity(lambda: self._node.destroy_service(created))

    def _answer(self, answer: Answer, request: bytes, waiting: Any) -> None:
        task = self._loop.create_task(self._guarded(answer, request))
        task.add_done_callback(lambda done: waiting.set_result(None if done.cancelled() else done.result()))

    async def _guarded(self, answer: Answer, request: bytes) -> bytes | None:
        try:
            return await answer(request)
        except Exception as error:  # noqa: BLE001 - a request of a robot must not end the bridge
            self._notices.warn(f"a request was answered by an empty response: {error}")
            return None

    def _qos(self, qos: Qos) -> Any:
        policies = import_module("rclpy.qos")
        return policies.QoSProfile(
            depth=qos.depth,
            reliability=policies.ReliabilityPolicy.RELIABLE if qos.reliable else policies.ReliabilityPolicy.BEST_EFFORT,
            durability=policies.DurabilityPolicy.TRANSIENT_LOCAL if qos.latched else policies.DurabilityPolicy.VOLATILE,
        )

    def _type(self, name: str) -> Any:
        """Return the class of a message, a service, or a part of an action."""
        package, folder, short = name.split("/")
        action, _, part = short.partition("_")
        try:
            module = import_module(f"{package}.{folder}")
            if folder != "action":
                return getattr(module, short)
            return getattr(getattr(module, action).Impl, _PARTS[part]) if part else getattr(module, action)
        except (ImportError, AttributeError, KeyError) as error:
            raise UnknownType(f"the robot's ROS has no type {name!r}: install package {package}") from error


def _entity(kind: Kind, topic: str, info: Any) -> Entity:
    policies = import_module("rclpy.qos")
    qos = info.qos_profile
    return Entity(
        kind,
        topic,
        info.topic_type,
        Qos(
            qos.reliability != policies.ReliabilityPolicy.BEST_EFFORT,
            qos.durability == policies.DurabilityPolicy.TRANSIENT_LOCAL,
            qos.depth,
        ),
        f"{info.node_namespace.rstrip('/')}/{info.node_name}",
        bytes(info.endpoint_gid).hex(),
    )


def _imported() -> Any:
    try:
        return import_module("rclpy")
    except ImportError as error:
        raise InvalidInput("rclpy is not installed: run the bridge by the Python of the robot's ROS 2") from error
