"""Node ``footprint``: takes the outline of what the robot carries, and removes it from the scans of the robot."""

import math
from collections.abc import Callable
from typing import ClassVar

import msgspec

from ppaas.decoding import from_json
from ppaas.errors import InvalidInput, TransformError
from ppaas.footprints import MAX_CORNERS, Footprint
from ppaas.messages.base.message import Message
from ppaas.messages.geometry_msgs import Polygon
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Node, Payload, Topic
from ppaas.nodes.frames import FrameNames, LateFrames
from ppaas.nodes.message_checks import expect
from ppaas.nodes.stop.node import GatedBus
from ppaas.perception.carried_load import LoadFilter

LARGEST = 10.0
"""Largest distance of a corner from the robot's origin [m]."""


class FootprintState(msgspec.Struct):
    """Checkpoint of the node: the outline of what the robot carries; empty if it carries nothing."""

    load: Footprint = ()


class FootprintNode(Node):
    """Keeps what the robot carries, as Nav2's costmaps keep the outline that they are given on their topics.

    While it carries something, the readings of that are removed from its scans before any node gets them.

    Parameters
    ----------
    context : Context
        The node's context.
    bus : GatedBus
        Topics of the clone.
    changed : callable
        Called with the outline of what the robot carries whenever that changes.
    load : Footprint
        What it carries at the beginning.
    names : FrameNames, optional
        Names of the robot's frames.
    """

    name: ClassVar[str] = "footprint"
    subscribes: ClassVar[tuple[Topic, ...]] = (
        topics.LOCAL_LOAD, topics.GLOBAL_LOAD, topics.TF, topics.TF_STATIC,
    )  # fmt: skip

    def __init__(
        self, context: Context, bus: GatedBus, changed: Callable[[Footprint], None], load: Footprint = (),
        names: FrameNames | None = None,
    ) -> None:  # fmt: skip
        super().__init__(context)
        self._changed, self._frames = changed, LateFrames(names)
        self._load: Footprint = ()
        self._filter: LoadFilter | None = None
        self._use(load)
        bus.gate(topics.SCAN.name, self._passed)

    def _use(self, load: Footprint) -> None:
        self._load, self._filter = load, LoadFilter(load) if load else None

    def _passed(self, payload: Payload) -> Payload:
        """Return a scan without what the robot carries."""
        if self._filter is None:
            return payload
        scan = expect(payload if isinstance(payload, Message) else payload.to_message(), LaserScan)
        try:
            mount = self._frames.now().mount(scan.header.frame_id)
        except TransformError:
            return scan  # no node can use it either
        return self._filter.without_load(scan, mount)

    def on_message(self, topic: str, message: Payload) -> None:
        """Take an outline, or keep a transform.

        Raises
        ------
        InvalidInput
            The outline has one or two corners, or too many, or one that is not finite or too far.
        """
        if isinstance(message, TFMessage):
            self._frames.keep(topic, message, self.context.elapsed(), self.context.now())
            return
        load = outline_in(expect(message, Polygon))
        if load != self._load:
            self._use(load)
            self._changed(load)

    def checkpoint(self) -> bytes:
        """Return what the robot carries, as JSON."""
        return msgspec.json.encode(FootprintState(self._load))

    def restore(self, state: bytes) -> None:
        """Carry what a checkpoint contains."""
        load = from_json(state, FootprintState).load
        if load != self._load:
            self._use(load)
            self._changed(load)


def outline_in(polygon: Polygon) -> Footprint:
    """Return the outline in a message; empty for none.

    Raises
    ------
    InvalidInput
        It has one or two corners, or too many, or one that is not finite or too far.
    """
    corners = tuple((point.x, point.y) for point in polygon.points)
    if corners and not 3 <= len(corners) <= MAX_CORNERS:
        raise InvalidInput(f"an outline has 3 to {MAX_CORNERS} corners, or none, not {len(corners)}")
    if not all(math.hypot(x, y) <= LARGEST for x, y in corners):
        raise InvalidInput(f"a corner of the outline is not finite, or more than {LARGEST:g} m from the robot's origin")
    return corners


def load_in(checkpoint: bytes | None) -> Footprint:
    """Return what the robot of a checkpoint of this node carries; nothing without one.

    Raises
    ------
    msgspec.MsgspecError
        It is not valid.
    """
    return () if checkpoint is None else from_json(checkpoint, FootprintState).load
