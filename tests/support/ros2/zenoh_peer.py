"""Node of ROS 2 over Zenoh, independent of the bridge: keys, tokens and attachments as rmw_zenoh's design has them."""

import itertools
import json
import struct
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import zenoh
from zenoh.ext import CacheConfig, HistoryConfig, declare_advanced_publisher, declare_advanced_subscriber

from ppaas.wire.ros import ros_types

SENSOR, DEFAULT, LATCHED = "2::,5:,:,:,,", "::,10:,:,:,,", ":1:,1:,:,:,,"
GID = bytes(range(16))


def attachment(sequence: int) -> bytes:
    return struct.pack("<qqB16s", sequence, time.time_ns(), 16, GID)


class Peer:
    """Node that connects to a router.

    Parameters
    ----------
    endpoint : str
        Endpoint of the router.
    name, namespace : str
        Names of the node.
    release : str
        Release of ROS 2.
    domain : int
        Domain of ROS 2.
    authority : Path, optional
        Certificate of the authority that routers with TLS have theirs from.
    """

    def __init__(
        self,
        endpoint: str,
        name: str,
        *,
        namespace: str = "",
        release: str = "jazzy",
        domain: int = 0,
        authority: Path | None = None,
    ) -> None:
        config = zenoh.Config()
        settings: dict[str, Any] = {
            "mode": "client",
            "connect/endpoints": [endpoint],
            "scouting/multicast/enabled": False,
        }
        if authority is not None:
            settings["transport/link/tls/root_ca_certificate"] = str(authority)
        for key, value in (settings | {"timestamping/enabled": True}).items():
            config.insert_json5(key, json.dumps(value))
        self.session = zenoh.open(config)
        self.types, self.domain, self.namespace = ros_types(release), domain, namespace
        self._numbers = itertools.count(1)
        self._head = f"@ros2_lv/{domain}/{self.session.info.zid()}/0"
        self._tail = f"%/{namespace.replace('/', '%') or '%'}/{name}"
        self._kept: list[Any] = [self.session.liveliness().declare_token(f"{self._head}/0/NN/{self._tail}")]

    def _declare(self, code: str, topic: str, kind: str, qos: str) -> tuple[str, str]:
        package, folder, short = kind.split("/")
        typename, type_hash = f"{package}::{folder}::dds_::{short}_", self.types.type_hash(kind)
        full = f"{self.namespace}/{topic}"
        described = f"{full.replace('/', '%')}/{typename}/{type_hash}/{qos}"
        token = f"{self._head}/{next(self._numbers)}/{code}/{self._tail}/{described}"
        self._kept.append(self.session.liveliness().declare_token(token))
        return f"{self.domain}{full}/{typename}", type_hash

    def publisher(self, topic: str, kind: str, qos: str = DEFAULT) -> Callable[[dict[str, Any]], None]:
        key, type_hash = self._declare("MP", topic, kind, qos)
        if qos == LATCHED:
            cache = CacheConfig(max_samples=1)
            declared: Any = declare_advanced_publisher(
                self.session, f"{key}/{type_hash}", cache=cache, publisher_detection=True
            )
        else:
            declared = self.session.declare_publisher(f"{key}/{type_hash}")
        self._kept.append(declared)
        count = itertools.count(1)
        return lambda message: declared.put(self.types.encode(kind, message), attachment=attachment(next(count)))

    def subscribe(self, topic: str, kind: str, received: Callable[[dict[str, Any]], None], qos: str = DEFAULT) -> None:
        """Subscribe as nodes do: to messages of the same hash."""
        key, type_hash = self._declare("MS", topic, kind, qos)

        def handle(sample: zenoh.Sample) -> None:
            received(self.types.decode(kind, sample.payload.to_bytes()))

        declared: Any
        if qos == LATCHED:
            history = HistoryConfig(detect_late_publishers=True)
            declared = declare_advanced_subscriber(self.session, f"{key}/{type_hash}", handle, history=history)
        else:
            declared = self.session.declare_subscriber(f"{key}/{type_hash}", handle)
        self._kept.append(declared)

    def call(self, service: str, kind: str, request: dict[str, Any], timeout: float = 10.0) -> dict[str, Any]:
        """Call a service; blocks."""
        key, type_hash = self._declare("SC", service, kind, DEFAULT)
        replies = self.session.get(
            f"{key}/{type_hash}",
            payload=self.types.encode(f"{kind}_Request", request),
            attachment=attachment(7),
            target=zenoh.QueryTarget.ALL_COMPLETE,
            consolidation=zenoh.ConsolidationMode.NONE,
            timeout=timeout,
        )
        for reply in replies:
            if reply.ok:
                sequence, _, size, gid = struct.unpack("<qqB16s", reply.ok.attachment.to_bytes())
                assert (sequence, size, gid) == (7, 16, GID), "the reply is that of another request"
                return self.types.decode(f"{kind}_Response", reply.ok.payload.to_bytes())
        raise TimeoutError(service)

    def graph(self) -> list[str]:
        """Return the tokens of all nodes."""
        replies = self.session.liveliness().get(f"@ros2_lv/{self.domain}/**", timeout=2.0)
        return sorted(str(reply.ok.key_expr) for reply in replies if reply.ok)

    def close(self) -> None:
        self.session.close()


class Recorder:
    """Messages of a topic, which arrive in a thread of Zenoh."""

    def __init__(self) -> None:
        self.messages: list[dict[str, Any]] = []
        self._arrived = threading.Condition()

    def __call__(self, message: dict[str, Any]) -> None:
        with self._arrived:
            self.messages.append(message)
            self._arrived.notify_all()

    def wait(self, count: int = 1, timeout: float = 10.0) -> list[dict[str, Any]]:
        """Wait for the message number ``count``, and return all; blocks."""
        with self._arrived:
            assert self._arrived.wait_for(lambda: len(self.messages) >= count, timeout), "no message arrived in time"
            return list(self.messages)
