"""Names of topics, services and nodes, as they arrive from clients."""

import re

from ppaas.errors import MalformedMessage

_NAME = re.compile(r"/?[A-Za-z~][\w~]*(/[\w~]+)*")
MAX_NAME = 255


def normalise(name: str) -> str:
    """Return a graph name without its leading slash: the form used inside.

    Raises
    ------
    MalformedMessage
        Not a ROS graph name, or longer than 255 characters.
    """
    if len(name) > MAX_NAME or not _NAME.fullmatch(name):
        raise MalformedMessage(f"not a ROS graph name: {name[:64]!r}")
    return name.removeprefix("/")
