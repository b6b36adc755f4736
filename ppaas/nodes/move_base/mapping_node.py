"""Node ``move_base`` of a robot that makes its map."""

from typing import ClassVar

from ppaas.nodes import topics
from ppaas.nodes.base import Payload, Topic
from ppaas.nodes.move_base.node import MoveBaseNode
from ppaas.nodes.move_base.static_layer import StaticLayer


class MappingMoveBaseNode(MoveBaseNode):
    """Move Base of a robot that makes its map: the static layer is that of the topics ``map`` and ``map_updates``."""

    subscribes: ClassVar[tuple[Topic, ...]] = (
        *MoveBaseNode.subscribes, topics.GRID_SLAM_STATUS, *StaticLayer.subscribes
    )  # fmt: skip

    def on_message(self, topic: str, message: Payload) -> None:
        """Handle a message; raises as that of Move Base does."""
        if self._static_layer is None or not self._static_layer.take(message):
            super().on_message(topic, message)
