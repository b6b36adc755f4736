"""Node of ROS 2 on a Zenoh session, as rmw_zenoh has it: topics, services and so actions; no ROS.

A session in mode ``router`` is the router to which robots connect; one in mode ``client`` connects to theirs.
"""

import asyncio
import contextlib
import itertools
import json
import socket
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ppaas.clock import epoch
from ppaas.distribution import check_versions, install_hint
from ppaas.errors import InvalidInput, MalformedMessage, Unavailable
from ppaas.wire.ros import ros_types
from ppaas.wire.ros.graph import Entity, Kind, Qos, release_of
from ppaas.wire.ros.rmw_zenoh import ZenohNode, gid_of, pack_attachment, parse_token, topic_key, unpack_attachment
from robots.bridges.core.notices import Notices
from robots.bridges.core.robot_graph import find_namespaces
from robots.bridges.core.transport import Answer, Closable, Publisher, Received, Transport

PORT = 7447
"""Port of Zenoh routers."""

GRAPH_WAIT = 0.5
"""Time for which the release of ROS is looked for in the graph [s]."""

DEFAULT_RELEASE = "jazzy"

LOOK = 1.0
"""Longest time for which robots of other domains are looked for [s]."""


@dataclass(frozen=True, slots=True)
class ZenohOptions:
    """Options of a Zenoh session.

    Parameters
    ----------
    listen : tuple of str
        Endpoints on which robots reach the bridge, which is then the router: ``tcp/0.0.0.0:7447``.
    connect : tuple of str
        Endpoints of routers to connect to. With neither, the router of this computer is taken if there is one; else
        the bridge listens on port 7447.
    config : Path, optional
        File of Zenoh's configuration (JSON5), for TLS and access control; the endpoints above replace its own.
    domain : int
        Domain of ROS.
    release : str
        Release of ROS; empty to find it in the graph.
    """

    listen: tuple[str, ...] = ()
    connect: tuple[str, ...] = ()
    config: Path | None = None
    domain: int = 0
    release: str = ""


class _Entity:
    """Publisher, subscriber or server: its token, and its declaration in Zenoh; both end when they are not referenced.

    Parameters
    ----------
    kept : set
        Entities of the node, among which this one is until it is closed.
    token, declared : object
        Token and declaration.
    """

    def __init__(self, kept: "set[_Entity]", token: Any, declared: Any) -> None:
        self._kept, self._token, self._declared = kept, token, declared
        kept.add(self)

    def close(self) -> None:
        self._kept.discard(self)
        self._token.undeclare()
        self._declared.undeclare()


class _Publisher(_Entity):
    def __init__(self, kept: set[_Entity], token: Any, declared: Any, gid: bytes) -> None:
        super().__init__(kept, token, declared)
        self._put, self._gid, self._sequence = declared.put, gid, itertools.count(1)

    def publish(self, data: bytes) -> None:
        self._put(data, attachment=pack_attachment(next(self._sequence), int(epoch() * 1e9), self._gid))


@dataclass(slots=True)
class _Graph:
    """Entities of the other nodes, by their tokens."""

    own: str = ""
    entities: dict[str, Entity] = field(default_factory=dict)


MAX_ENTITIES = 10_000
"""Largest number of entities in a graph."""


class ZenohTransport(Transport):
    """Transport over Zenoh.

    Parameters
    ----------
    options : ZenohOptions
        Options of the session.
    name : str
        Name of the node.

    Attributes
    ----------
    session : zenoh.Session
        Valid after ``open``.
    """

    qos_matters = False
    session: Any

    def __init__(self, options: ZenohOptions, name: str = "ppaas_bridge") -> None:
        self._options, self._name, self.domain = options, name, options.domain
        self._zenoh = _imported()
        self._graph = _Graph()
        self._numbers = itertools.count(1)
        self._notices = Notices()
        self._answering: set[asyncio.Task[None]] = set()
        self._kept: set[_Entity] = set()

    # -- session -------------------------------------------------------------------------------------------------------

    async def open(self, changed: Callable[[], None]) -> None:
        """Open the session, and find the release of ROS in the graph."""
        self._loop = asyncio.get_running_loop()
        self._changed = changed
        config = self._config()
        try:
            self.session = await asyncio.to_thread(self._zenoh.open, config)
        except self._zenoh.ZError as error:
            raise Unavailable(f"Zenoh cannot be opened: {error}") from error
        self._node = ZenohNode(self._options.domain, str(self.session.info.zid()), "/", self._name)
        self._graph.own = f"@ros2_lv/{self._options.domain}/{self._node.session}/"
        self._token = self.session.liveliness().declare_token(self._node.token)
        self._watcher = self.session.liveliness().declare_subscriber(
            f"@ros2_lv/{self._options.domain}/**", self.in_loop(self._token_changed), history=True
        )
        await asyncio.sleep(GRAPH_WAIT)
        release = self._options.release or release_of(self._graph.entities.values())
        self.types = ros_types(release or DEFAULT_RELEASE)
        self._notices.info(f"types of messages are those of ROS 2 {self.types.release}")

    async def close(self) -> None:
        """Close the session."""
        for task in self._answering:
            task.cancel()
        await asyncio.gather(*self._answering, return_exceptions=True)
        if hasattr(self, "session"):
            await asyncio.to_thread(self.session.close)

    def _config(self) -> Any:
        options = self._options
        listen, connect = options.listen, options.connect
        if not listen and not connect and options.config is None:
            if _is_open("localhost", PORT):
                connect = (f"tcp/localhost:{PORT}",)
            else:
                listen = (f"tcp/[::]:{PORT}",)
        try:
            config = self._zenoh.Config.from_file(options.config) if options.config else self._zenoh.Config()
            settings: dict[str, Any] = {
                "scouting/multicast/enabled": False,
                "timestamping/enabled": True,
                "transport/shared_memory/enabled": False,  # its pool is memory that a small robot misses
            }
            if listen:
                settings |= {"mode": "router", "listen/endpoints": list(listen)}
                self._notices.info(f"robots connect to {', '.join(listen)}")
            elif connect:
                settings |= {"mode": "client"}
            if connect:
                settings |= {"connect/endpoints": list(connect)}
                self._notices.info(f"the router of the robot is {', '.join(connect)}")
            for key, value in settings.items():
                config.insert_json5(key, json.dumps(value))
        except self._zenoh.ZError as error:
            raise InvalidInput(f"Zenoh cannot be configured: {error}") from error
        return config

    def in_loop(self, call: Callable[..., None]) -> Callable[[Any], None]:
        """Return a callback for threads of Zenoh, in which errors would vanish."""

        def callback(sample: Any) -> None:
            if not self._loop.is_closed():
                self._loop.call_soon_threadsafe(call, sample)

        return callback

    # -- graph ---------------------------------------------------------------------------------------------------------

    def entities(self) -> tuple[Entity, ...]:
        """Return the entities of the other nodes."""
        return tuple(self._graph.entities.values())

    async def other_domains(self) -> tuple[int, ...]:
        """Return the other domains of the router in which somebody publishes odometry or scans."""
        tokens = await asyncio.to_thread(self._tokens, "@ros2_lv/*/**")
        found = set()
        for token in tokens:
            with contextlib.suppress(MalformedMessage):
                entity, domain = parse_token(token), token.split("/")[1]
                if entity is not None and find_namespaces([entity]) and domain.isdecimal():
                    found.add(int(domain))
        return tuple(sorted(found - {self.domain}))

    def _tokens(self, pattern: str) -> list[str]:
        replies = self.session.liveliness().get(pattern, timeout=LOOK)
        return [str(reply.ok.key_expr) for reply in itertools.islice(replies, MAX_ENTITIES) if reply.ok]

    def _token_changed(self, sample: Any) -> None:
        token = str(sample.key_expr)
        if token.startswith(self._graph.own):
            return
        if sample.kind == self._zenoh.SampleKind.DELETE:
            self._graph.entities.pop(token, None)
        elif len(self._graph.entities) < MAX_ENTITIES:
            try:
                entity = parse_token(token)
            except MalformedMessage as error:
                self._notices.warn(f"ignored in the graph: {error}")
                return
            if entity is not None:
                self._graph.entities[token] = entity
        self._changed()

    def _declare_token(self, kind: Kind, name: str, type_name: str, qos: Qos) -> tuple[Any, bytes]:
        number = next(self._numbers)
        entity = Entity(kind, name, type_name, qos, self._name, str(number), self.types.type_hash(type_name))
        token = self._node.entity_token(number, entity)
        return self.session.liveliness().declare_token(token), gid_of(token)

    # -- topics --------------------------------------------------------------------------------------------------------

    def publisher(self, topic: str, type_name: str, qos: Qos) -> Publisher:
        """Return a publisher; the last messages of a latched one are kept for late subscribers."""
        key = topic_key(self._options.domain, topic, type_name, self.types.type_hash(type_name))
        if qos.latched:
            from zenoh.ext import CacheConfig, declare_advanced_publisher  # noqa: PLC0415 - of the extra ros2

            declared = declare_advanced_publisher(
                self.session, key, cache=CacheConfig(max_samples=qos.depth), publisher_detection=True
            )
        else:
            declared = self.session.declare_publisher(key, congestion_control=self._zenoh.CongestionControl.DROP)
        token, gid = self._declare_token(Kind.PUBLISHER, topic, type_name, qos)
        return _Publisher(self._kept, token, declared, gid)

    def subscribe(self, topic: str, type_name: str, qos: Qos, received: Received) -> Closable:
        """Subscribe to a topic, whatever the hash of its type."""
        key = topic_key(self._options.domain, topic, type_name)
        handler = self.in_loop(lambda sample: received(sample.payload.to_bytes()))
        remote = self._zenoh.Locality.REMOTE
        declared: Any
        if qos.latched:
            from zenoh.ext import HistoryConfig, declare_advanced_subscriber  # noqa: PLC0415

            history = HistoryConfig(detect_late_publishers=True)
            declared = declare_advanced_subscriber(self.session, key, handler, history=history, allowed_origin=remote)
        else:
            declared = self.session.declare_subscriber(key, handler, allowed_origin=remote)
        token, _ = self._declare_token(Kind.SUBSCRIBER, topic, type_name, qos)
        return _Entity(self._kept, token, declared)

    # -- services ------------------------------------------------------------------------------------------------------

    def serve(self, service: str, type_name: str, answer: Answer) -> Closable:
        """Serve a service; each request is answered in a separate task."""
        key = topic_key(self._options.domain, service, type_name, self.types.type_hash(type_name))

        def received(query: Any) -> None:
            task = self._loop.create_task(self._reply(query, key, answer))
            self._answering.add(task)
            task.add_done_callback(self._answering.discard)

        declared = self.session.declare_queryable(key, self.in_loop(received), complete=True)
        token, _ = self._declare_token(Kind.SERVER, service, type_name, Qos())
        return _Entity(self._kept, token, declared)

    async def _reply(self, query: Any, key: str, answer: Answer) -> None:
        try:
            sequence, client = unpack_attachment(query.attachment.to_bytes() if query.attachment else b"")
            response = await answer(query.payload.to_bytes() if query.payload else b"")
            query.reply(key, response, attachment=pack_attachment(sequence, int(epoch() * 1e9), client))
        except Exception as error:  # noqa: BLE001 - a request of a robot must not end the bridge
            self._notices.warn(f"a request to {key.split('/', 1)[1]} was not answered: {error}")
        finally:
            query.drop()


def _is_open(host: str, port: int) -> bool:
    try:
        with socket.create_connection((host, port), timeout=0.5):
            return True
    except OSError:
        return False


def _imported() -> Any:
    check_versions("ros2")
    try:
        import xxhash  # noqa: F401, PLC0415 - of identities in the graph
        import zenoh  # noqa: PLC0415 - of the extra ros2
        import zenoh.ext  # noqa: PLC0415
    except ImportError as error:
        raise InvalidInput(f"robots with rmw_zenoh need the extra ros2: {install_hint('ros2')}") from error
    return zenoh
