"""Topics of the robot that go to the cloud."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from ppaas.errors import InvalidInput
from ppaas.wire.ros.graph import SENSOR, Qos
from ppaas.wire.ros.types import to_json
from robots.bridges.core.localization import RobotLocalization
from robots.bridges.core.parts import BridgeParts
from robots.bridges.core.robot_graph import TF_MESSAGE, PublishedTopic, RobotGraph
from robots.bridges.core.tables import ODOMETRY, SCAN, UpTopic
from robots.bridges.core.transport import Closable

COMPRESSED = "camera/depth/image_raw/compressedDepth"
RAW = "camera/depth/image_raw"
"""Depth images, of which the compressed ones are carried if the robot has both."""


@dataclass(slots=True)
class _Carried:
    source: PublishedTopic
    subscription: Closable


class Upward:
    """Subscriptions to the robot's topics.

    Parameters
    ----------
    parts : BridgeParts
        Ends of the bridge.
    localization : RobotLocalization
        Takes odometry, and the publishers of it.
    """

    def __init__(self, parts: BridgeParts, localization: RobotLocalization) -> None:
        self._parts, self._localization = parts, localization
        self._carried: dict[str, _Carried] = {}
        self._last: dict[str, float] = {}

    def update(self, graph: RobotGraph, known: frozenset[str]) -> None:
        """Subscribe to what the robot publishes now, and to nothing else.

        Parameters
        ----------
        graph : RobotGraph
            The robot.
        known : frozenset of str
            Topics of the clone.
        """
        has, up = self._parts.transport.has_type, self._parts.transport.tables.up
        carried = [topic for topic in up if (not topic.clone or topic.cloud in known) and has(topic.type)]
        sources = {topic.cloud: graph.source(topic) for topic in carried}
        if sources.get(COMPRESSED) is not None:
            sources[RAW] = None
        odometry = sources.get(ODOMETRY.cloud)
        if odometry is not None:
            self._localization.publishers(one.id for one in odometry.publishers)
        for topic in up:
            self._carry(topic.cloud, topic.type, sources.get(topic.cloud), self._receiver(topic))
        for name in ("tf_static", "tf") if has(TF_MESSAGE) else ():
            self._carry(name, TF_MESSAGE, graph.transforms(name), self._transforms(name))

    async def renew(self) -> None:
        """Send a new clone what the robot publishes once."""
        if transforms := self._parts.frames.kept:
            await self._publish_static(transforms)

    def close(self) -> None:
        """End all subscriptions."""
        for name in list(self._carried):
            self._drop(name)

    def _carry(
        self, name: str, type_name: str, source: PublishedTopic | None, received: Callable[[bytes], None]
    ) -> None:
        before = self._carried.get(name)
        if before is not None and source is not None and before.source.same_as(source):
            return
        if before is not None:
            self._drop(name)
        if source is None:
            return
        reliable = name in ("tf_static", "goal_pose", "initialpose") and all(
            publisher.qos.reliable for publisher in source.publishers
        )
        latched = source.latched and (name == "tf_static" or reliable)
        qos = Qos(reliable=reliable, latched=latched, depth=100 if "tf" in name else SENSOR.depth)
        self._carried[name] = _Carried(source, self._parts.transport.subscribe(source.topic, type_name, qos, received))
        self._parts.notices.info(f"{source.topic} goes to the cloud as {name!r}")

    def _drop(self, name: str) -> None:
        self._carried.pop(name).subscription.close()

    # -- messages ------------------------------------------------------------------------------------------------------

    def _receiver(self, topic: UpTopic) -> Callable[[bytes], None]:
        def received(data: bytes) -> None:
            now = self._parts.clock()
            if topic.period and now - self._last.get(topic.cloud, -topic.period) < topic.period:
                return
            self._last[topic.cloud] = now
            try:
                message = self._parts.transport.types.decode(topic.type, data)
            except InvalidInput as error:
                self._parts.notices.warn(f"a message of {topic.cloud!r} cannot be read: {error}")
                return
            if self._is_wanted(topic, message, now):
                self._send(topic, to_json(message))

        return received

    def _is_wanted(self, topic: UpTopic, message: dict[str, Any], now: float) -> bool:
        if topic is ODOMETRY:
            self._parts.frames.odometry(message)
            self._parts.time.heard(message["header"]["stamp"], now)
            self._localization.odometry(message, now)
        elif topic is SCAN:
            frame = message["header"]["frame_id"]
            if not self._parts.frames.may_send_scan(frame.lstrip("/"), now):
                self._parts.notices.info(f"scans wait for the transform of their frame {frame!r}")
                return False
        return True

    def _send(self, topic: UpTopic, message: bytes) -> None:
        if topic.reliable:
            self._parts.start(self._parts.link.publish(topic.cloud, message))
        else:
            self._parts.link.publish_newest(topic.cloud, message)

    def _transforms(self, name: str) -> Callable[[bytes], None]:
        def received(data: bytes) -> None:
            try:
                transforms = self._parts.transport.types.decode(TF_MESSAGE, data)["transforms"]
            except InvalidInput as error:
                self._parts.notices.warn(f"a message of {name!r} cannot be read: {error}")
                return
            wanted = self._parts.frames.upward(transforms, self._parts.clock(), static=name == "tf_static")
            if not wanted:
                return
            if name == "tf_static":
                self._parts.frames.keep(wanted)
                self._parts.start(self._publish_static(wanted))
            else:
                children = ",".join(one["child_frame_id"] for one in wanted)
                self._parts.link.publish_newest(name, to_json({"transforms": wanted}), f"tf:{children}")
                self._parts.frames.sent(wanted)

        return received

    async def _publish_static(self, transforms: list[Mapping[str, Any]]) -> None:
        await self._parts.link.publish("tf_static", to_json({"transforms": transforms}))
        self._parts.frames.sent(transforms)
