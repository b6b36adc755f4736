"""What nodes keep of ``tf``: the tree, and when each moving frame was last heard of."""

from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.topics import TF_STATIC
from ppaas.transforms.planar import TransformTree, is_level

MAP = "map"
"""The frame of the map, in which Move Base plans and drives."""

ODOM = "odom"
BASE_LINK = "base_link"


class FrameListener:
    """A transform tree that follows ``tf`` and ``tf_static``."""

    def __init__(self) -> None:
        self.tree = TransformTree()
        self._heard: dict[str, float] = {}

    def hear(self, topic: str, message: TFMessage, now: float) -> None:
        """Take a message. Frames out of the plane (wheels, cameras) are none of navigation's and are left out.

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
        """Return how long nothing was heard of a frame [s], by the clock of this home and not that of the stamps."""
        return now - self._heard.get(child, float("-inf"))
