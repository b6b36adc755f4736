"""Types of actions, and of their goals, results and feedback.

In ROS 2 an action has one type, ``package/action/Name``. In ROS 1 each of its topics has one,
``package/NameActionGoal`` and so on, whose field ``goal``, ``result`` or ``feedback`` is what is meant here.
"""

from collections.abc import Mapping
from typing import Literal

import msgspec

from ppaas.errors import UnknownType
from ppaas.messages import message_type, message_types
from ppaas.messages.base.message import Message
from ppaas.wire.actions import actions, topics_of
from ppaas.wire.names import ros1_type, ros2_type

Part = Literal["Goal", "Result", "Feedback"]

NAVIGATE_TO_POSE_TYPE = "nav2_msgs/NavigateToPose"
"""Type of the action that has no separate topics."""


def type_of_action(name: str, topics: Mapping[str, str]) -> str:
    """Return the type of an action as spelled in ROS 2; empty if there is none of this name.

    Parameters
    ----------
    name : str
        Name of the action, without a leading slash.
    topics : mapping of str to str
        All topics, and their types as spelled in ROS 1.
    """
    if name not in actions(topics):
        return ""
    own = topics_of(name, topics) == name
    return ros2_type(topics[f"{name}/goal"].removesuffix("ActionGoal") if own else NAVIGATE_TO_POSE_TYPE, "action")


def known_actions() -> list[str]:
    """Return the types of all actions whose definition is known, as spelled in ROS 2."""
    named = {name.removesuffix("ActionGoal") for name in message_types() if name.endswith("ActionGoal")}
    return sorted(ros2_type(name, "action") for name in named | {NAVIGATE_TO_POSE_TYPE})


def part_of_action(name: str, part: Part) -> type[Message]:
    """Return the type of the goals, results or feedback of a type of actions.

    Raises
    ------
    UnknownType
        The type is unknown, or not a type name.
    """
    base = ros1_type(name).removesuffix("Action")
    try:
        return message_type(f"{base}{part}")
    except UnknownType:
        pass
    try:
        on_topic = message_type(f"{base}Action{part}")
    except UnknownType as error:
        raise UnknownType(f"unknown action type {name[:64]!r}; known: {', '.join(known_actions())}") from error
    [kind] = [field.type for field in msgspec.structs.fields(on_topic) if field.name == part.lower()]
    assert isinstance(kind, type) and issubclass(kind, Message)
    return kind
