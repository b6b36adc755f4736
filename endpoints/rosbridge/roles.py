"""What a socket may say, by its role."""

from typing import Literal, cast

from ppaas.errors import InvalidParameter, NotPermitted
from ppaas.nodes.topics import policy_of

Role = Literal["robot", "operator"]


def role_of(name: str) -> Role:
    """Return the role that a client asks for.

    Raises
    ------
    InvalidParameter
        There is no such role.
    """
    if name not in ("robot", "operator"):
        raise InvalidParameter(f"a role is 'robot' or 'operator', not {name[:32]!r}")
    return cast(Role, name)


def check_may_publish(role: Role, topic: str) -> None:
    """Let only the robot speak of what it senses.

    Raises
    ------
    NotPermitted
        An operator publishes a sensor's topic.
    """
    if role != "robot" and policy_of(topic).robot_only:
        raise NotPermitted(f"only the robot itself publishes {topic!r}")
