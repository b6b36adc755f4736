"""New maps: a robot file that names ``new:office-2`` lets the robot make a map, to be published as ``office-2``."""

NEW = "new:"
"""Prefix of the id, in the place of the map of a robot file."""


def new_map_id(name: str) -> str | None:
    """Return the id under which the new map is to be published, as given; None if ``name`` is a published map."""
    return name.removeprefix(NEW) if name.startswith(NEW) else None
