"""Parameters of nodes and plug-ins: their base, how they are read, and checks that dataclasses of them share."""

import math
from typing import TypeVar

import msgspec

from ppaas.errors import InvalidParameter


class Parameters(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Base of a node's parameters: names, types and defaults, as ROS has them."""


P = TypeVar("P", bound=Parameters)


def read_parameters(cls: type[P], node: str, given: object) -> P:
    """Return a node's parameters from JSON's dict.

    Raises
    ------
    InvalidParameter
        One is unknown, of the wrong type or out of range; the text names the valid ones.
    """
    try:
        return msgspec.convert(given, cls)
    except msgspec.ValidationError as error:
        known = ", ".join(sorted(cls.__struct_fields__))
        raise InvalidParameter(f"parameters of {node!r}: {error}; known: {known}") from error


def check_scalar(name: str, value: object, kind: object) -> None:
    """Let a boolean or a finite number pass.

    Parameters
    ----------
    name : str
        For the error.
    value : object
        What was given; a whole number is a float as well.
    kind : type
        ``bool``, ``int`` or ``float``.

    Raises
    ------
    InvalidParameter
        It is none of that type, or not finite.
    """
    if kind is bool:
        if not isinstance(value, bool):
            raise InvalidParameter(f"{name} must be true or false, not {value!r}")
        return
    if isinstance(value, bool) or not isinstance(value, int if kind is int else (int, float)):
        raise InvalidParameter(f"{name} must be a number of type {getattr(kind, '__name__', kind)}, not {value!r}")
    if not math.isfinite(value):
        raise InvalidParameter(f"{name} must be finite, not {value}")


def check_not_negative(name: str, value: float, *, zero: bool) -> None:
    """Let a number pass that is above 0, or where ``zero`` is true 0 as well.

    Raises
    ------
    InvalidParameter
        It is less.
    """
    if value < 0 or (value == 0 and not zero):
        raise InvalidParameter(f"{name} must be {'at least' if zero else 'above'} 0, not {value}")
