"""Roles of clients, and the topics that each may publish."""

from typing import Literal, cast

from ppaas.errors import InvalidParameter, NotPermitted
from ppaas.nodes.topics import policy_of

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
