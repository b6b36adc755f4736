"""Listener of ``tf`` and ``tf_static``: the transform tree, and the time of the last transform of each frame."""

from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.topics import TF_STATIC
from ppaas.transforms.planar import TransformTree, is_level

MAP = "map"
"""Frame of the map, in which Move Base plans and drives."""

ODOM = "odom"
BASE_LINK = "base_link"


class FrameListener:
    """A transform tree that follows ``tf`` and ``tf_static``."""

    def __init__(self) -> None:
        self.tree = TransformTree()
        self._heard: dict[str, float] = {}

    def hear(self, topic: str, message: TFMessage, now: float) -> None:
        """Add the transforms of a message, except frames that are not level, such as those of wheels and cameras.

        Raises
        ------
        TransformError
            A transform is not finite, has no frame, or closes a loop.
        """
        static = topic == TF_STATIC.name
        for transform in message.transforms:
            if is_level(transform.transform.rotation):
                self.tree.set_message(transform, static=static)
                self._heard[transform.child_frame_id.lstrip("/")] = now

    def silence(self, child: str, now: float) -> float:
        """Return the time since the last transform of a frame, by the executor's clock instead of the stamps [s]."""
        return now - self._heard.get(child, float("-inf"))
