"""Roles of clients, the topics that each may publish, and the topics whose messages name their sender."""

from typing import Literal, cast

import msgspec

from ppaas.errors import InvalidParameter, MalformedMessage, NotPermitted
from ppaas.nodes.topics import TELEOP_CMD, policy_of

Role = Literal["robot", "operator"]


def role_of(name: str) -> Role:
    """Return the role with this name.

    Raises
    ------
    InvalidParameter
        The role does not exist.
    """
    if name not in ("robot", "operator"):
        raise InvalidParameter(f"role must be 'robot' or 'operator', not {name[:32]!r}")
    return cast(Role, name)


def check_may_publish(role: Role, topic: str) -> None:
    """Raise unless a role may publish a topic; only the robot may publish its sensors.

    Raises
    ------
    NotPermitted
        The topic is reserved for the robot, and the role is operator.
    """
    if role != "robot" and policy_of(topic).robot_only:
        raise NotPermitted(f"only the robot itself may publish {topic!r}")


_decoder = msgspec.json.Decoder(dict[str, msgspec.Raw])


def signed(topic: str, message: bytes, user: str) -> bytes:
    """Return a message of a user, with the user's name if it is of a topic whose messages name their sender.

    Raises
    ------
    MalformedMessage
        The message of such a topic is no JSON object by the standard.
    """
    if topic != TELEOP_CMD.name:
        return message
    try:
        fields = _decoder.decode(message)
    except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
        raise MalformedMessage(f"a message on {topic!r} must be a JSON object: {error}") from error
    return msgspec.json.encode(fields | {"driver": user})
