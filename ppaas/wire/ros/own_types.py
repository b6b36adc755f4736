"""Types of ROS 2 together with the cloud's own messages that ROS 2 lacks.

Recordings and viewers get every topic as CDR with the definition of its type, so that third-party programs can
read all of them. The definitions of the cloud's own types are derived from the structs.
"""

from functools import cache

from ppaas.errors import UnknownType
from ppaas.messages.registry import message_type
from ppaas.wire.ros.types import RosTypes
from ppaas.wire.typedefs import full_text

RELEASE = "jazzy"
"""Release of ROS 2 whose definitions are used."""


def types_with(name: str) -> RosTypes:
    """Return types that have a message: one of ROS 2, or one of the cloud's own.

    Parameters
    ----------
    name : str
        Name of the type, as spelled in ROS 1 or ROS 2.

    Raises
    ------
    UnknownType
        Neither has it.
    InvalidInput
        ``rosbags`` is not installed; the text says how to install it.
    """
    types = _types()
    if name not in types:
        types.learn(name, full_text(message_type(name)))
    return types


def has_type(name: str) -> bool:
    """Return whether ``types_with`` has a message; raises ``InvalidInput`` as it does."""
    try:
        return name in types_with(name)
    except UnknownType:
        return False


@cache
def _types() -> RosTypes:
    return RosTypes(RELEASE)  # not the shared one of the release, which does not learn
