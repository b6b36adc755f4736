"""``tf2_msgs``."""

from ppaas.messages.base.message import Message
from ppaas.messages.geometry_msgs import TransformStamped

MAX_FRAMES = 1000
"""Limit of frames of one robot; further frames are ignored."""


class TFMessage(Message):
    """``tf2_msgs/TFMessage``."""

    transforms: list[TransformStamped]


def merged(earlier: TFMessage, later: TFMessage) -> TFMessage:
    """Return the transforms of two messages, the later one of each child frame."""
    frames = {each.child_frame_id.lstrip("/"): each for each in (*earlier.transforms, *later.transforms)}
    return TFMessage(list(frames.values())[:MAX_FRAMES])
