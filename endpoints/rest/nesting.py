"""Nesting of JSON values: objects and lists within each other."""

from collections.abc import Iterable
from typing import Any

MAX_NESTING = 32
"""Largest number of objects and lists within each other in free-form values, such as parameters."""

MAX_SHOWN = 200
"""Largest number of these that is shown of a stored value; pydantic writes no more than some 250."""

HIDDEN = {"error": "this value is nested too deeply to be shown: replace it"}
"""Stands for a stored value that cannot be shown."""


def is_deeper(value: Any, depth: int) -> bool:
    """Return whether a JSON value has more than ``depth`` objects and lists within each other."""
    level = [value] if isinstance(value, dict | list) else []
    for _ in range(depth):
        level = [child for parent in level for child in _children(parent) if isinstance(child, dict | list)]
    return bool(level)


def showable(value: Any) -> Any:
    """Return a stored value, or `HIDDEN` if an earlier release stored one that is nested too deeply."""
    return HIDDEN if is_deeper(value, MAX_SHOWN) else value


def _children(parent: Any) -> Iterable[Any]:
    return parent.values() if isinstance(parent, dict) else parent
