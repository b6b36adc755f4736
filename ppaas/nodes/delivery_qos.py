"""What must arrive at a node, wherever it runs, and how two homes tell that they mean the same message."""

from hashlib import blake2b

from ppaas.messages import encode
from ppaas.messages.message import Message

STREAMS = frozenset({
    "scan", "odom", "tf", "tf_static", "cmd_vel", "amcl_pose", "particlecloud", "plan", "robots", "people",
    "camera/depth/image_raw", "camera/depth/image_raw/compressedDepth",
    "move_base/feedback", "move_base/status", "follow_waypoints/feedback", "follow_waypoints/status",
})  # fmt: skip
"""Topics on which the next message makes up for a lost one, whoever speaks: a node of the clone may be on the robot."""


def must_arrive(topic: str) -> bool:
    """Tell whether no message makes up for a lost one on a topic."""
    return topic not in STREAMS


def fingerprint(topic: str, message: Message) -> str:
    """Return what tells a message from all others: the same for the same message, wherever it was decoded."""
    return blake2b(topic.encode() + b"\0" + encode(message), digest_size=8).hexdigest()
