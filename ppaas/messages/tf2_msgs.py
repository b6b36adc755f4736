"""``tf2_msgs``."""

from ppaas.messages.geometry_msgs import TransformStamped
from ppaas.messages.message import Message


class TFMessage(Message):
    """``tf2_msgs/TFMessage``."""

    transforms: list[TransformStamped]
