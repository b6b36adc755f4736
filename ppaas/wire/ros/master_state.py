"""State of a master of ROS 1: which nodes publish, subscribe and serve.

Source: ``getSystemState`` and ``getTopicTypes`` of https://wiki.ros.org/ROS/Master_API.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ppaas.errors import MalformedMessage
from ppaas.wire.names import ros2_type

MAX_NAMES = 20_000
"""Largest number of topics and services of a master."""

SAME = {"tf/tfMessage": "tf2_msgs/msg/TFMessage"}
"""Types of older releases that are the same as one of Noetic."""

Nodes = Mapping[str, frozenset[str]]
"""Names of nodes, by the names of topics or services."""


@dataclass(frozen=True, slots=True)
class MasterState:
    """Nodes that are registered, by topic as publishers and subscribers, and by service."""

    publishers: Nodes
    subscribers: Nodes
    services: Nodes


def read_state(value: Any) -> MasterState:
    """Return the state in a response to ``getSystemState``.

    Raises
    ------
    MalformedMessage
        The value is not a state, or names more than `MAX_NAMES` topics or services.
    """
    if not isinstance(value, list) or len(value) != 3:
        raise MalformedMessage("no state of a master: it is not three lists")
    return MasterState(*map(_nodes, value))


def read_types(value: Any) -> dict[str, str]:
    """Return the types of topics in a response to ``getTopicTypes``, spelled as in ROS 2.

    Raises
    ------
    MalformedMessage
        The value is not a list of names and types.
    """
    if not isinstance(value, list) or len(value) > MAX_NAMES:
        raise MalformedMessage("no types of topics: it is not a list, or too long")
    found = {}
    for pair in value:
        if not isinstance(pair, list) or [type(one) for one in pair] != [str, str]:
            raise MalformedMessage("no types of topics: not each item is a name and a type")
        found[pair[0]] = SAME.get(pair[1]) or (ros2_type(pair[1], "msg") if "/" in pair[1] else "")
    return found


def _nodes(value: Any) -> Nodes:
    if not isinstance(value, list) or len(value) > MAX_NAMES:
        raise MalformedMessage("no state of a master: not a list of names, or too long")
    found = {}
    for pair in value:
        if not isinstance(pair, list) or len(pair) != 2 or not isinstance(pair[1], list):
            raise MalformedMessage("no state of a master: not each item is a name and its nodes")
        name, nodes = pair
        if not all(isinstance(one, str) for one in (name, *nodes)):
            raise MalformedMessage("no state of a master: a name is not text")
        found[name] = frozenset(nodes)
    return found
