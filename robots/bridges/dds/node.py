"""Node of ROS 2 on DDS, by Cyclone DDS: topics with robots of any RMW that is on DDS; no ROS.

Services do not work with robots whose DDS is Fast DDS, the default of ROS 2: rmw_fastrtps identifies a request by a
part of the RTPS header that Cyclone DDS can neither write nor read. A client would find the service and never get an
answer.
So the transport offers none.
"""

import asyncio
import itertools
import os
import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ppaas.errors import InvalidInput, Unavailable
from ppaas.wire.ros import ros_types
from ppaas.wire.ros.graph import LATCHED, Entity, Kind, Qos, release_of
from robots.bridges.core.notices import Notices
from robots.bridges.core.transport import Closable, Publisher, Received, Transport
from robots.bridges.dds import cyclone
from robots.bridges.dds.cyclone import IdlTypes, cyclone_configuration

GRAPH_WAIT = 0.5
"""Time for which the release of ROS is looked for in the graph [s]."""

DEFAULT_RELEASE = "jazzy"

POLL = 0.1
"""Longest time that the thread of readers waits before it checks whether the transport is closed [s]."""

BATCH = 64
"""Largest number of messages that are taken from a reader at once."""

ENTITIES = "ros_discovery_info", "rmw_dds_common/msg/ParticipantEntitiesInfo"
"""Topic on which nodes of ROS state their readers and writers."""


@dataclass(frozen=True, slots=True)
class DdsOptions:
    """Options of DDS.

    Parameters
    ----------
    domain : int
        Domain of ROS.
    release : str
        Release of ROS; empty to find it in the graph.
    config : Path, optional
        File of Cyclone DDS's configuration (XML).
    """

    domain: int = 0
    release: str = ""
    config: Path | None = None


class _Endpoint:
    def __init__(self, transport: "DdsTransport", entity: Any, topic: Any) -> None:
        self.entity, self._transport, self._topic = entity, transport, topic

    def close(self) -> None:
        self._transport.remove(self)


class _Writer(_Endpoint):
    def publish(self, data: bytes) -> None:
        # The length of a serialized message is a multiple of four.
        code = self._transport.write(self.entity._ref, data + bytes(-len(data) % 4))
        if code < 0:
            self._transport.notices.warn(f"DDS did not take a message (error {code})")


class _Reader(_Endpoint):
    condition: Any
    received: Received


class DdsTransport(Transport):
    """Transport over DDS. A thread waits for messages of all readers.

    Parameters
    ----------
    options : DdsOptions
        Options of DDS.
    name : str
        Name of the node.
    """

    services = False
    lacking = (
        "over DDS the bridge offers no actions and services of Navigation2: send goals by the topic 'goal_pose' "
        "(RViz: 2D Goal Pose), or take --transport zenoh or rclpy"
    )

    def __init__(self, options: DdsOptions, name: str = "ppaas_bridge") -> None:
        self._options, self._name, self.domain = options, name, options.domain
        self._dds = cyclone.imported()
        self.write = self._dds.write
        self.notices = Notices()
        self._entities: dict[str, Entity] = {}
        self._readers: dict[int, _Reader] = {}
        self._writers: set[_Writer] = set()
        self._lock = threading.Lock()
        self._closing = threading.Event()
        self._numbers = itertools.count()
        self._thread: threading.Thread | None = None
        self._info: _Writer | None = None

    # -- participant ---------------------------------------------------------------------------------------------------

    async def open(self, changed: Callable[[], None]) -> None:
        """Join the domain, and find the release of ROS in the graph."""
        self._loop, self._changed = asyncio.get_running_loop(), changed
        dds = self._dds
        try:
            self._domain = dds.Domain(self._options.domain, _configuration(self._options))
            enclave = dds.Qos(dds.Policy.Userdata(b"enclave=/;"))  # else it is no node to ROS
            self._participant = dds.DomainParticipant(self._options.domain, qos=enclave)
        except dds.DDSException as error:
            raise Unavailable(f"DDS cannot be opened in domain {self._options.domain}: {error}") from error
        self._own = self._participant.guid
        self._waits = dds.WaitSet(self._participant)
        self._watchers = [
            (kind, dds.BuiltinDataReader(self._participant, topic))
            for kind, topic in ((Kind.PUBLISHER, dds.publications), (Kind.SUBSCRIBER, dds.subscriptions))
        ]
        self._watching = [(kind, reader, dds.condition(reader)) for kind, reader in self._watchers]
        for _, _, condition in self._watching:
            self._waits.attach(condition)
        self._thread = threading.Thread(target=self._listen, name="dds", daemon=True)
        self._thread.start()
        await asyncio.sleep(GRAPH_WAIT)
        release = self._options.release or self._release()
        self.types = ros_types(release)
        self._idl = IdlTypes(self.types)
        self.notices.info(f"types of messages are those of ROS 2 {release}")
        self._info = self._new_writer(ENTITIES[0], ENTITIES[1], LATCHED)

    def _release(self) -> str:
        found = self.entities()
        if found and not any(entity.type_hash for entity in found):
            return "humble"  # before Iron, endpoints did not state the hashes of their types
        return release_of(found) or DEFAULT_RELEASE

    async def close(self) -> None:
        """Leave the domain. The thread ends first: Cyclone DDS must not be used while Python ends."""
        self._closing.set()
        if self._thread is not None:
            await asyncio.to_thread(self._thread.join)

    def entities(self) -> tuple[Entity, ...]:
        """Return the publishers and subscribers of the other nodes."""
        return tuple(self._entities.values())

    # -- topics --------------------------------------------------------------------------------------------------------

    def publisher(self, topic: str, type_name: str, qos: Qos) -> Publisher:
        """Return a publisher."""
        writer = self._new_writer(f"rt{topic}", type_name, qos)
        self._writers.add(writer)
        self._announce()
        return writer

    def subscribe(self, topic: str, type_name: str, qos: Qos, received: Received) -> Closable:
        """Subscribe to a topic."""
        dds = self._dds
        described = dds.Topic(self._participant, f"rt{topic}", self._idl.of(type_name))
        wanted = cyclone.of(dds, qos, self.types.type_hash(type_name)) + dds.Qos(dds.Policy.IgnoreLocal.Participant)
        reader = _Reader(self, dds.DataReader(self._participant, described, qos=wanted), described)
        reader.condition, reader.received = dds.condition(reader.entity), received
        with self._lock:
            self._readers[next(self._numbers)] = reader
            self._waits.attach(reader.condition)
        self._announce()
        return reader

    def remove(self, endpoint: _Endpoint) -> None:
        """Remove a reader or a writer."""
        with self._lock:
            self._writers.discard(endpoint)
            for number, reader in list(self._readers.items()):
                if reader is endpoint:
                    self._waits.detach(reader.condition)
                    del self._readers[number]
        self._announce()

    def _new_writer(self, topic: str, type_name: str, qos: Qos) -> _Writer:
        dds = self._dds
        described = dds.Topic(self._participant, topic, self._idl.of(type_name))
        wanted = cyclone.of(dds, qos, self.types.type_hash(type_name))
        return _Writer(self, dds.DataWriter(self._participant, described, qos=wanted), described)

    def _announce(self) -> None:
        """State the readers and writers of the node, as ``ros2 node info`` shows them."""
        if self._info is None or self._closing.is_set():
            return

        def gid(entity: Any) -> dict[str, bytes]:
            # Humble's has 24 bytes, those after the GUID zero.
            size = 24 if self.types.release == "humble" else 16
            return {"data": bytes(entity.guid.bytes).ljust(size, b"\0")}

        node = {
            "node_namespace": "/",
            "node_name": self._name,
            "reader_gid_seq": [gid(reader.entity) for reader in self._readers.values()],
            "writer_gid_seq": [gid(writer.entity) for writer in self._writers],
        }
        message = {"gid": gid(self._participant), "node_entities_info_seq": [node]}
        self._info.publish(self.types.encode(ENTITIES[1], message))

    # -- thread --------------------------------------------------------------------------------------------------------

    def _listen(self) -> None:
        while not self._closing.is_set():
            self._waits.wait(self._dds.duration(milliseconds=round(POLL * 1000)))
            for kind, reader, condition in self._watching:
                if condition.triggered:
                    self._post(self._noticed, kind, reader.take(N=BATCH))
            with self._lock:
                for reader in self._readers.values():
                    if reader.condition.triggered:
                        self._take(reader)

    def _take(self, reader: _Reader) -> None:
        samples = self._dds.take(reader.entity._ref, self._dds.ANY, BATCH)
        if isinstance(samples, int):
            self._post(self.notices.warn, f"DDS did not give a message (error {samples})")
            return
        for data, info in samples:
            if info.valid_data:
                self._post(reader.received, bytes(data))

    def _post(self, call: Callable[..., None], *arguments: Any) -> None:
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(call, *arguments)

    # -- graph ---------------------------------------------------------------------------------------------------------

    def _noticed(self, kind: Kind, samples: list[Any]) -> None:
        for sample in samples:
            identity = str(sample.key)
            if not cyclone.is_alive(self._dds, sample):
                self._entities.pop(identity, None)
                continue
            entity = cyclone.entity_of(self._dds, kind, sample)
            if entity is not None and sample.participant_key != self._own:
                self._entities[identity] = entity
        self._changed()


def _configuration(options: DdsOptions) -> str:
    if options.config is not None:
        try:
            return options.config.read_text()
        except OSError as error:
            raise InvalidInput(f"the configuration of DDS cannot be read: {error}") from error
    if uri := os.environ.get("CYCLONEDDS_URI"):
        return uri
    return cyclone_configuration(os.environ)
