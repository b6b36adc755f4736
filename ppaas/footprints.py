"""Footprints of robots as costmap_2d reads them: a list or text of corners, open or closed."""

import math

from ppaas.errors import InvalidParameter

Footprint = tuple[tuple[float, float], ...]
"""Corners of an outline around the robot's origin, in order [m]; empty for a disc."""

MAX_CORNERS = 1000
"""Limit of the corners of a footprint."""

MAX_TEXT = 100_000
"""Limit of a footprint's text [characters]."""

DISC_CORNERS = 16
"""Corners of the outline of a disc, as in costmap_2d."""

_WANTED = "footprint must be a list of corners [[x, y], …] [m], or such a list as text"


def read_footprint(given: object) -> object:
    """Return a footprint as a list of corners; anything else than a list or text is returned unchanged.

    As in costmap_2d, text has brackets around each corner and around all, and commas or spaces between numbers. A
    corner that repeats the one before is left out, and so is one of the first and the last if they are the same. Empty
    text is no outline.

    Raises
    ------
    InvalidParameter
        Text is not a list of corners, or there are too many.
    """
    corners = _of_text(given) if isinstance(given, str) else given
    if not isinstance(corners, list | tuple):
        return corners
    if len(corners) > MAX_CORNERS:
        raise InvalidParameter(f"footprint must have at most {MAX_CORNERS} corners, not {len(corners)}")
    return [corner for number, corner in enumerate(corners) if corner != corners[number - 1]] or list(corners)


def check_corners(footprint: Footprint) -> None:
    """Raise ``InvalidParameter`` if a footprint has fewer than three corners, or one that is not finite."""
    if len(footprint) < 3 or not all(math.isfinite(number) for corner in footprint for number in corner):
        raise InvalidParameter("footprint must be a list of at least three corners x, y [m]")


def goes_around(corners: Footprint) -> bool:
    """Return whether an outline goes around the origin in one direction."""
    turns = [a[0] * b[1] - a[1] * b[0] for a, b in zip(corners, (*corners[1:], *corners[:1]), strict=True)]
    return len(corners) >= 3 and all(map(math.isfinite, turns)) and (min(turns) > 0.0 or max(turns) < 0.0)


def disc_outline(radius: float) -> Footprint:
    """Return the outline of a disc around the origin [m], as corners."""
    angles = [2.0 * math.pi * number / DISC_CORNERS for number in range(DISC_CORNERS)]
    return tuple((radius * math.cos(angle), radius * math.sin(angle)) for angle in angles)


def _of_text(text: str) -> list[list[float]]:
    """Return the corners in text such as ``[[0.3, 0.2], [0.3 -0.2]]``."""
    if len(text) > MAX_TEXT:
        raise InvalidParameter(f"footprint must have at most {MAX_TEXT} characters, not {len(text)}")
    if not text.strip():
        return []
    words = text.replace("[", " [ ").replace("]", " ] ").replace(",", " ").split()
    if words[:1] != ["["] or words[-1:] != ["]"] or len(words) < 2:
        raise InvalidParameter(f"{_WANTED}, not {text[:64]!r}")
    inner = words[1:-1]
    try:
        corners = [_corner(*inner[at : at + 4]) for at in range(0, len(inner), 4)]
    except (TypeError, ValueError) as error:
        raise InvalidParameter(f"{_WANTED}, not {text[:64]!r}") from error
    return corners


def _corner(begin: str, x: str, y: str, end: str) -> list[float]:
    if (begin, end) != ("[", "]"):
        raise ValueError("a corner is in brackets")
    return [float(x), float(y)]
