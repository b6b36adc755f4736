"""Topics of the clone that go to the robot: map, plans, costmaps, pose, particles, transforms, velocities."""

import asyncio
from collections.abc import Callable
from typing import Any

import msgspec
import numpy as np

from ppaas.errors import MalformedMessage
from ppaas.wire.ros.graph import Qos
from robots.bridges.core.parts import BridgeParts
from robots.bridges.core.robot_graph import TF_MESSAGE, TWIST_STAMPED, RobotGraph
from robots.bridges.core.tables import MAP, MAP_METADATA, MAP_UPDATES, PARTICLES, DownTopic
from robots.bridges.core.transport import Publisher

TF_QOS = Qos(depth=100)


class Downward:
    """Publishers of what the clone publishes.

    A topic is requested of the cloud only while somebody in ROS subscribes to it, except for the map, which late
    subscribers must get at once.

    Parameters
    ----------
    parts : BridgeParts
        Ends of the bridge.
    """

    def __init__(self, parts: BridgeParts) -> None:
        self._parts = parts
        self._publishers: dict[str, tuple[str, Publisher]] = {}
        self._wanted: set[str] = set()
        self._map: dict[str, Any] | None = None
        self._map_readers: frozenset[str] = frozenset()
        self._patched = False

    def update(self, graph: RobotGraph) -> None:
        """Publish on the topics of the robot's namespace, and request what somebody there subscribes to."""
        if self._parts.transport.has_type(TF_MESSAGE):
            self._publish_on("tf", graph.tf_topic(), TF_MESSAGE, TF_QOS)
            self._request("tf", TF_MESSAGE, self._transforms, wanted=True)
        for topic in self._parts.transport.tables.down:
            if not self._parts.transport.has_type(topic.type):
                continue
            name = graph.full(topic.name)
            self._publish_on(topic.cloud, name, topic.type, topic.qos)
            self._request(
                topic.cloud,
                topic.cloud_type,
                self._receiver(topic),
                wanted=topic.always or bool(graph.subscribers(name)),
            )
        readers = graph.subscribers(graph.full(MAP.name))
        if self._patched and readers - self._map_readers and self._map is not None:
            self._publish(MAP, self._map)  # else those would see the map as it was before its updates
            self._patched = False
        self._map_readers = readers

    def close(self) -> None:
        """Remove the publishers."""
        for _, publisher in self._publishers.values():
            publisher.close()
        self._publishers.clear()

    def _publish_on(self, cloud: str, name: str, type_name: str, qos: Qos) -> None:
        before = self._publishers.get(cloud)
        if before is not None:
            if before[0] == name:
                return
            before[1].close()
        self._publishers[cloud] = name, self._parts.transport.publisher(name, type_name, qos)

    def _request(self, cloud: str, type_name: str, received: Callable[[bytes], None], *, wanted: bool) -> None:
        if wanted and cloud not in self._wanted:
            self._wanted.add(cloud)
            self._parts.start(self._parts.link.subscribe(cloud, type_name, received))
        elif not wanted and cloud in self._wanted:
            self._wanted.remove(cloud)
            self._parts.start(self._parts.link.unsubscribe(cloud))

    # -- messages ------------------------------------------------------------------------------------------------------

    def _receiver(self, topic: DownTopic) -> Callable[[bytes], None]:
        def received(message: bytes) -> None:
            values = msgspec.json.decode(message)
            if topic is MAP:
                self._map, self._patched = values, False
            elif topic is MAP_UPDATES:
                self._patch(values)
            elif topic is PARTICLES:
                values = particle_cloud(values)
            self._publish(topic, values)
            if topic is MAP and MAP_METADATA.cloud in self._publishers:
                self._publish(MAP_METADATA, values.get("info"))

        return received

    def _publish(self, topic: DownTopic, values: Any) -> None:
        try:
            self._publishers[topic.cloud][1].publish(self._parts.transport.types.encode(topic.type, values))
        except MalformedMessage as error:
            self._parts.notices.warn(f"a message of {topic.cloud!r} cannot be sent to the robot: {error}")

    def _patch(self, update: dict[str, Any]) -> None:
        """Keep the map current for late subscribers."""
        if self._map is not None:
            self._map["data"] = patched(self._map, update)
            self._patched = True

    def _transforms(self, message: bytes) -> None:
        wanted = self._parts.frames.downward(msgspec.json.decode(message)["transforms"])
        if wanted:
            self._publishers["tf"][1].publish(self._parts.transport.types.encode(TF_MESSAGE, {"transforms": wanted}))


def particle_cloud(poses: dict[str, Any]) -> dict[str, Any]:
    """Return a ``nav2_msgs/ParticleCloud`` of the poses of a ``geometry_msgs/PoseArray``: all weigh the same."""
    weight = 1.0 / max(len(poses["poses"]), 1)
    return {
        "header": poses.get("header"),
        "particles": [{"pose": pose, "weight": weight} for pose in poses["poses"]],
    }


def patched(grid: dict[str, Any], update: dict[str, Any]) -> np.ndarray[Any, np.dtype[np.int8]]:
    """Return the cells of a map after a ``map_msgs/OccupancyGridUpdate``.

    Raises
    ------
    MalformedMessage
        The rectangle of the update is not within the map, or does not match its cells.
    """
    info = grid["info"]
    cells = np.array(grid["data"], np.int8).reshape(info["height"], info["width"])
    x, y, width, height = (int(update[key]) for key in ("x", "y", "width", "height"))
    inside = min(x, y, width, height) >= 0 and x + width <= info["width"] and y + height <= info["height"]
    if not inside or len(update["data"]) != width * height:
        raise MalformedMessage("an update of the map that does not fit into it")
    cells[y : y + height, x : x + width] = np.array(update["data"], np.int8).reshape(height, width)
    return cells.ravel()


# -- velocities for the base -------------------------------------------------------------------------------------------

SILENCE = 0.5
"""Age at which a velocity counts no more [s], as docs/protocol.md demands of a base."""

ZEROS, ZERO_PERIOD = 5, 0.1
"""Number of zero velocities that stop a base, in case some are lost, and the time between them [s]."""

ZERO: dict[str, Any] = {"linear": {}, "angular": {}}


class VelocityPublishers:
    """Publishers of velocities.

    Parameters
    ----------
    parts : BridgeParts
        Ends of the bridge.
    """

    def __init__(self, parts: BridgeParts) -> None:
        self._parts = parts
        self._publishers: dict[tuple[str, str], Publisher] = {}
        self._moving = False
        self._timer: asyncio.TimerHandle | None = None
        self._zeros = 0

    def update(self, topics: dict[str, set[str]]) -> None:
        """Publish on these topics with these types, and on no others."""
        wanted = {(topic, kind) for topic, kinds in topics.items() for kind in kinds}
        for gone in self._publishers.keys() - wanted:
            self._publishers.pop(gone).close()
        for topic, kind in sorted(wanted - self._publishers.keys()):
            self._publishers[topic, kind] = self._parts.transport.publisher(topic, kind, Qos(depth=1))

    @property
    def topics(self) -> list[str]:
        """Topics on which velocities are published, with their types."""
        return [f"{topic} ({kind.rpartition('/')[2]})" for topic, kind in sorted(self._publishers)]

    def received(self, message: bytes) -> None:
        """Publish a velocity of the cloud, a ``geometry_msgs/Twist`` as JSON."""
        twist = msgspec.json.decode(message)
        self._moving = any(value for part in ("linear", "angular") for value in twist.get(part, {}).values())
        self._zeros = 0
        self._publish(twist)
        self._restart(SILENCE)

    def stop(self) -> None:
        """Stop the base if it was ordered to move: the cloud is silent, or the bridge ends."""
        if not self._moving:
            return
        self._publish(ZERO)
        self._zeros += 1
        self._moving = self._zeros < ZEROS
        self._restart(ZERO_PERIOD)

    def close(self) -> None:
        """Stop the base, and remove the publishers."""
        if self._moving:
            self._publish(ZERO)
        if self._timer is not None:
            self._timer.cancel()
        for publisher in self._publishers.values():
            publisher.close()
        self._publishers.clear()

    def _restart(self, delay: float) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._timer = asyncio.get_running_loop().call_later(delay, self.stop) if self._moving else None

    def _publish(self, twist: dict[str, Any]) -> None:
        for (_, kind), publisher in self._publishers.items():
            message = twist
            if kind == TWIST_STAMPED:
                message = {
                    "header": {"stamp": self._parts.time.now(), "frame_id": self._parts.frames.base},
                    "twist": twist,
                }
            publisher.publish(self._parts.transport.types.encode(kind, message))
