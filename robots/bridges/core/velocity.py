"""Velocities for the base: of the type that it expects, and zero when the cloud falls silent."""

import asyncio
from typing import Any

import msgspec

from ppaas.wire.ros.graph import Qos
from robots.bridges.core.parts import Parts
from robots.bridges.core.robot_graph import TWIST_STAMPED
from robots.bridges.core.transport import Publisher

SILENCE = 0.5
"""Age at which a velocity counts no more [s], as docs/protocol.md demands of a base."""

ZEROS, ZERO_PERIOD = 5, 0.1
"""Number of zero velocities that stop a base, in case some are lost, and the time between them [s]."""

ZERO: dict[str, Any] = {"linear": {}, "angular": {}}


class Velocity:
    """Publishers of velocities.

    Parameters
    ----------
    parts : Parts
        Ends of the bridge.
    """

    def __init__(self, parts: Parts) -> None:
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
