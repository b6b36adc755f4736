"""The syntax of names: of users, maps, robots and plans.

One rule for all, so that a name is also a valid file name, column value, URL segment and Zenoh key: no slash, no
leading dot, nothing that needs quoting.
"""

import re

from ppaas.errors import InvalidInput
from ppaas.maps.new_map import NEW, new_map_id

PATTERN = "[A-Za-z0-9][A-Za-z0-9_.-]{0,63}"
_NAME = re.compile(PATTERN)


def is_name(name: str) -> bool:
    """Return whether a name is valid."""
    return _NAME.fullmatch(name) is not None


def check_name(kind: str, name: str) -> str:
    """Return the name, if it is valid.

    Parameters
    ----------
    kind : str
        Kind of the named thing, for the error message.
    name : str

    Raises
    ------
    InvalidInput
        The name is not valid.
    """
    if not is_name(name):
        shown = name if len(name) <= 64 else name[:64] + "…"
        raise InvalidInput(
            f"{shown!r} is not a valid name of a {kind}: use 1 to 64 letters, digits, '_', '.' and '-', with a letter"
            " or digit first"
        )
    return name


Group = tuple[str, str]
"""User and map: whose robots, and where."""


def check_group(user: str, map_id: str) -> Group:
    """Return a user and a map; ``InvalidInput`` if a name is not valid."""
    return check_name("user", user), check_name("map", map_id)


def check_task_key(user: str, map_id: str, task_id: str) -> tuple[str, str, str]:
    """Return the key of a task; ``InvalidInput`` if a name is not valid."""
    return *check_group(user, map_id), check_name("task", task_id)


def check_building_key(user: str, building: str) -> tuple[str, str]:
    """Return the key of a building; ``InvalidInput`` if a name is not valid."""
    return check_name("user", user), check_name("building", building)


def check_webhook_key(user: str, hook: str) -> tuple[str, str]:
    """Return the key of a webhook; ``InvalidInput`` if a name is not valid."""
    return check_name("user", user), check_name("webhook", hook)


def check_delivery_key(user: str, hook: str, delivery: str) -> tuple[str, str, str]:
    """Return the key of a delivery; ``InvalidInput`` if a name is not valid."""
    return *check_webhook_key(user, hook), check_name("delivery", delivery)


def check_robot_map(name: str) -> str:
    """Return the map of a robot, if it is a valid id, or ``new:`` with one.

    Raises
    ------
    InvalidInput
        The id is not valid.
    """
    new = new_map_id(name)
    return check_name("map", name) if new is None else NEW + check_name("new map", new)
