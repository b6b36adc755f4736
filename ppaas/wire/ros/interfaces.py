"""Message types that services and actions of ROS 2 consist of, from the text of their definitions.

A service is two messages and, in its hash, an event; an action is three services and messages around its own three.

Source: ROS 2 design, "Actions" and REP-2016.
"""

from collections.abc import Callable, Mapping
from typing import Any

from ppaas.errors import MalformedMessage

Fields = tuple[list[Any], list[Any]]
"""Constants and fields of a message, as ``rosbags`` describes them."""

Parse = Callable[[str, str], dict[str, Fields]]
"""Called with the text of a message and its name; returns its description by that name."""

BASE, NAME, SEQUENCE = 1, 2, 4
"""Kinds of fields in the descriptions of ``rosbags``: a number or text, a message, a list."""

_UUID: Any = ("goal_id", (NAME, "unique_identifier_msgs/msg/UUID"))
_TIME: Any = ("stamp", (NAME, "builtin_interfaces/msg/Time"))


def parsed(definitions: Mapping[str, str], parse: Parse) -> tuple[dict[str, Fields], dict[str, Fields]]:
    """Return the messages of definitions, and the services of them.

    Parameters
    ----------
    definitions : mapping of str to str
        Text of each definition by its full name, such as ``nav2_msgs/action/Wait``.
    parse : callable
        Parser of messages.

    Returns
    -------
    messages : dict
        Messages by full name, also of services and actions (``nav2_msgs/action/Wait_Goal``).
    services : dict
        Services by full name, also of actions (``nav2_msgs/action/Wait_SendGoal``), as the types whose
        hashes ROS 2 computes: request, response and event.
    """
    messages: dict[str, Fields] = {}
    services: dict[str, Fields] = {}
    for name, text in definitions.items():
        kind = name.split("/")[1]
        parts = _parts(name, text, parse)
        if kind == "msg":
            messages[name] = parts[0]
        elif kind == "srv":
            services |= _service(name, parts[0], parts[1], messages)
        else:
            services |= _action(name, parts, messages)
    return messages, services


def _parts(name: str, text: str, parse: Parse) -> list[Fields]:
    package, kind, _ = name.split("/")
    sections = "\n".join(line.strip() for line in text.splitlines()).split("---")
    if len(sections) != {"msg": 1, "srv": 2, "action": 3}[kind]:
        raise MalformedMessage(f"the definition of {name!r} has {len(sections)} parts")
    placeholder = f"{package}/msg/Part"
    return [parse(section.strip(), placeholder)[placeholder] for section in sections]


def _service(name: str, request: Fields, response: Fields, messages: dict[str, Fields]) -> dict[str, Fields]:
    messages[f"{name}_Request"], messages[f"{name}_Response"] = request, response
    event = [
        ("info", (NAME, "service_msgs/msg/ServiceEventInfo")),
        ("request", (SEQUENCE, ((NAME, f"{name}_Request"), 1))),
        ("response", (SEQUENCE, ((NAME, f"{name}_Response"), 1))),
    ]
    fields = [(f"{part.lower()}_message", (NAME, f"{name}_{part}")) for part in ("Request", "Response", "Event")]
    return {f"{name}_Event": ([], event), name: ([], fields)}


def _action(name: str, parts: list[Fields], messages: dict[str, Fields]) -> dict[str, Fields]:
    for part, fields in zip(("Goal", "Result", "Feedback"), parts, strict=True):
        messages[f"{name}_{part}"] = fields
    messages[f"{name}_FeedbackMessage"] = ([], [_UUID, ("feedback", (NAME, f"{name}_Feedback"))])
    send: Fields = ([], [_UUID, ("goal", (NAME, f"{name}_Goal"))])
    accepted: Fields = ([], [("accepted", (BASE, ("bool", 0))), _TIME])
    result: Fields = ([], [("status", (BASE, ("int8", 0))), ("result", (NAME, f"{name}_Result"))])
    sent = _service(f"{name}_SendGoal", send, accepted, messages)
    return sent | _service(f"{name}_GetResult", ([], [_UUID]), result, messages)
