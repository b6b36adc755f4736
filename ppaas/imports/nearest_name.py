"""Known name that an unknown one is most like."""

import difflib
from collections.abc import Iterable

LIKE = 0.6
"""Smallest likeness of a name that is suggested in place of an unknown one, from 0 to 1."""


def nearest_name(name: str, known: Iterable[str], likeness: float = LIKE) -> str | None:
    """Return the known name that is most like a name, without regard to upper case; None if none is like it."""
    by_lower = {each.lower(): each for each in known}
    found = difflib.get_close_matches(name.lower(), by_lower, 1, likeness)
    return by_lower[found[0]] if found else None
