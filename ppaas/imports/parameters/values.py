"""Conversions of the values of other programs' parameters, which refuse what cannot be converted."""

import math
import re
from typing import Any

from ppaas.errors import InvalidParameter
from ppaas.footprints import check_corners, read_footprint
from ppaas.imports.parameters.rules import Convert

FINEST_OF_MPPI = 0.05
"""Smallest ``xy_goal_tolerance`` within which ``mppi`` comes to rest [m]."""

_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
_SUBSTITUTION = re.compile(r"\$\(|\$\{|<\w+>")
_PLACEHOLDER = re.compile(r"[A-Z][A-Z0-9]*(?:_[A-Z0-9]+)+")


def is_substitution(value: Any) -> bool:
    """Return whether a value is text that a launch file replaces, such as ``$(find-pkg-share pkg)``."""
    return isinstance(value, str) and _SUBSTITUTION.search(value) is not None


def is_replaced(value: Any, convert: Convert | None) -> bool:
    """Return whether a launch file replaces a value: a substitution, or ``SPEED_ZONE_ENABLED`` in place of a number."""
    if is_substitution(value):
        return True
    return convert in _NO_TEXT and isinstance(value, str) and _PLACEHOLDER.fullmatch(value) is not None


def number(value: Any) -> float:
    """Return a finite number. YAML reads ``1e-3`` as text, which ROS reads as a number."""
    if isinstance(value, str) and _NUMBER.fullmatch(value.strip()):
        value = float(value)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InvalidParameter(f"it must be a number, not {_shown(value)}")
    try:
        found = float(value)
    except OverflowError as error:
        raise InvalidParameter(f"it must be finite, not {_shown(value)}") from error
    if not math.isfinite(found):
        raise InvalidParameter(f"it must be finite, not {found}")
    return found


def magnitude(value: Any) -> float:
    """Return a number without its sign."""
    return abs(number(value))


def negated(value: Any) -> float:
    """Return minus the magnitude of a number: a speed in reverse."""
    return -abs(number(value))


def above_zero(value: Any) -> float:
    """Return a number above 0."""
    found = number(value)
    if found <= 0.0:
        raise InvalidParameter(f"it must be above 0, not {found:g}")
    return found


def unless_zero(value: Any) -> float | None:
    """Return a number above 0, or None for 0, which sets no limit."""
    found = number(value)
    if found < 0.0:
        raise InvalidParameter(f"it must not be negative, not {found:g}")
    return found or None


def if_above_zero(value: Any) -> float | None:
    """Return a number above 0, or None for 0 and below, which set no limit."""
    found = number(value)
    return found if found > 0.0 else None


def whole(value: Any) -> int:
    """Return a whole number, which may be written as 20.0."""
    found = number(value)
    if found != int(found):
        raise InvalidParameter(f"it must be a whole number, not {found:g}")
    return int(found)


def flag(value: Any) -> bool:
    """Return true or false."""
    if not isinstance(value, bool):
        raise InvalidParameter(f"it must be true or false, not {_shown(value)}")
    return value


def text(value: Any) -> str:
    """Return text that no launch file replaces."""
    if not isinstance(value, str):
        raise InvalidParameter(f"it must be text, not {_shown(value)}")
    return value


def frame(value: Any) -> str:
    """Return the name of a frame, which is no path: a slash before it means the same in ROS 1."""
    name = text(value).strip("/")
    if not name:
        raise InvalidParameter("it must be the name of a frame")
    return name


def corners(value: Any) -> list[list[float]]:
    """Return the corners of a footprint, given as a list or as text."""
    found = read_footprint(value)
    if not isinstance(found, list | tuple):
        raise InvalidParameter(f"it must be a list of corners [[x, y], …], not {_shown(value)}")
    pairs = []
    for each in found:
        if not isinstance(each, list | tuple) or len(each) != 2:
            raise InvalidParameter(f"it must be a list of corners [[x, y], …], not {_shown(value)}")
        pairs.append([number(each[0]), number(each[1])])
    check_corners(tuple((x, y) for x, y in pairs))
    return pairs


def numbers(value: Any, count: int) -> list[float]:
    """Return a list of numbers, or text such as ``[1, 2.5]``, as a list of this many numbers."""
    given = value.strip(" []").replace(",", " ").split() if isinstance(value, str) else value
    if not isinstance(given, list | tuple) or len(given) != count:
        raise InvalidParameter(f"it must be a list of {count} numbers, not {_shown(value)}")
    return [number(each) for each in given]


_NO_TEXT: tuple[Convert, ...] = (number, magnitude, negated, above_zero, if_above_zero, unless_zero, whole, flag)


def at_most(limit: float) -> Convert:
    """Return a conversion to a number that is not above a limit."""
    return lambda value: min(number(value), limit)


def at_least(least: float, kind: type[float] | type[int] = float) -> Convert:
    """Return a conversion that raises a number from 0 to the least one; negative ones stay, to be refused."""

    def converted(value: Any) -> float:
        found = kind(number(value))
        return least if 0 <= found < least else found

    return converted


def within(least: int, most: int) -> Convert:
    """Return a conversion that bounds a whole number."""
    return lambda value: min(max(int(number(value)), least), most)


def times(factor: float) -> Convert:
    """Return a conversion that multiplies a number."""
    return lambda value: number(factor * number(value))


def one_of(names: dict[str, str]) -> Convert:
    """Return a conversion of names; ``/`` and ``::`` after a package are the same."""

    def convert(value: Any) -> str:
        given = text(value).replace("/", "::")
        if given not in names:
            raise InvalidParameter(f"it must be one of {', '.join(names)}, not {_shown(value)}")
        return names[given]

    return convert


def names_of(value: Any) -> list[str]:
    """Return a list of names, which costmaps also write as words in one text."""
    if isinstance(value, str):
        return value.split()
    if isinstance(value, list | tuple):
        return [each for each in value if isinstance(each, str)]
    return []


def _shown(value: Any) -> str:
    shown = repr(value)
    return shown if len(shown) <= 64 else shown[:61] + "…"
