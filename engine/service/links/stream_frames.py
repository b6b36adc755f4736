"""Recognition of frames that may be lost: messages of streams, such as scans and odometry."""

import msgspec

from engine.protocols.session_frames import NumberedFrame
from ppaas.errors import PPaaSError
from ppaas.nodes.topics import policy_of
from ppaas.wire.binary.packing import operation_of


class _Publish(msgspec.Struct):
    op: str = ""
    topic: str = ""


_decoder = msgspec.json.Decoder(_Publish)


def is_stream(frame: NumberedFrame) -> bool:
    """Return whether a frame of a client publishes a message that may be lost.

    The topic may be below a namespace of the robot.
    """
    try:
        read = _decoder.decode(operation_of(frame.content) if frame.binary else frame.content)
    except (PPaaSError, msgspec.DecodeError, UnicodeError):
        return False
    name = read.topic.strip("/")
    return read.op == "publish" and any(policy_of(topic).stream for topic in (name, name.rpartition("/")[2]))
