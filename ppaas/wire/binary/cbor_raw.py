"""Messages in bytes of ROS for subscriptions with ``compression: cbor-raw``, as ``rosbridge_suite`` sends them.

A frame is a publication in CBOR whose ``msg`` has the time of sending, ``secs`` and ``nsecs``, and the ``bytes`` of the
message. They are encoded as in ROS 1 or, for clients that name their type as in ROS 2, as CDR with its header of four
bytes. Clients cannot publish in it: rosbridge sends such frames and receives none.

Source: ``rosbridge_library/capabilities/subscribe.py`` of ``RobotWebTools/rosbridge_suite``, branches ``ros1`` and
``ros2``.
"""

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

from ppaas.errors import InvalidInput
from ppaas.messages.base.std_msgs import Time
from ppaas.wire.binary.binary_frame import BinaryFrame


class RosType(NamedTuple):
    """Type of the messages of a subscription, in bytes of ROS 1 or of ROS 2.

    Parameters
    ----------
    name : str, optional
        Name as spelled in ROS 1; None for the type of the topic, which may not be known yet.
    ros2 : bool
    """

    name: str | None = None
    ros2: bool = False


Serialize: TypeAlias = Callable[[bytes, RosType], bytes]
"""Called with a message as JSON and its type; returns its bytes. Raises UnknownType, InvalidInput, MalformedMessage."""


def not_serialized(_message: bytes, _kind: RosType) -> bytes:
    """Raise ``InvalidInput``: messages are not serialized here."""
    raise InvalidInput("messages are not sent in bytes of ROS here")


def cbor_raw_frame(spelling: str, serialized: bytes, now: float) -> BinaryFrame:
    """Return the frame that publishes a message in bytes of ROS.

    Parameters
    ----------
    spelling : str
        Name of the topic as the client spells it.
    serialized : bytes
        The message.
    now : float
        Time of sending since the epoch [s].
    """
    import cbor2  # noqa: PLC0415  # needed only for clients of CBOR

    time = Time.of(now)
    content = {"secs": time.secs, "nsecs": time.nsecs, "bytes": serialized}
    return BinaryFrame(cbor2.dumps({"op": "publish", "topic": spelling, "msg": content}))
