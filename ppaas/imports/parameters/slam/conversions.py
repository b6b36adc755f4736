"""Conversions of the values of other mapping programs."""

from typing import Any

from ppaas.errors import InvalidParameter
from ppaas.imports.parameters.rules import Convert


def at_least(least: float, kind: type[float] | type[int] = float) -> Convert:
    """Return a function that raises a number that is 0 to the least one; negative numbers stay, to be refused."""

    def converted(value: Any) -> float:
        number = kind(_number(value))
        return least if 0 <= number < least else number

    return converted


def within(least: int, most: int) -> Convert:
    """Return a function that bounds a whole number."""
    return lambda value: min(max(int(_number(value)), least), most)


def scaled(factor: float) -> Convert:
    """Return a function that multiplies a number by a factor."""
    return lambda value: factor * _number(value)


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InvalidParameter(f"it must be a number, not {value!r}")
    return value
