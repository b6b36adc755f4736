"""Base class and checks of the parameters of nodes and plug-ins."""

import math
from typing import TypeVar

import msgspec

from ppaas.errors import InvalidParameter


class Parameters(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Base of a node's parameters: a struct of names, types and defaults, as in ROS."""


P = TypeVar("P", bound=Parameters)


def read_parameters(cls: type[P], node: str, given: object) -> P:
    """Return a node's parameters from a dict decoded from JSON.

    Raises
    ------
    InvalidParameter
        A parameter is unknown, of the wrong type or out of range; the text lists the valid names.
    """
    try:
        return msgspec.convert(given, cls)
    except msgspec.ValidationError as error:
        known = ", ".join(sorted(cls.__struct_fields__))
        raise InvalidParameter(f"parameters of {node!r}: {error}; known: {known}") from error


def check_scalar(name: str, value: object, kind: object) -> None:
    """Check that a value is a boolean or a finite number.

    Parameters
    ----------
    name : str
        Name of the parameter, for the error.
    value : object
        Its value; an int is valid where a float is expected.
    kind : type
        ``bool``, ``int`` or ``float``.

    Raises
    ------
    InvalidParameter
        The value has another type, or is not finite.
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
    """Check that a number is above 0, or at least 0 if ``zero`` is true.

    Raises
    ------
    InvalidParameter
        The number is smaller.
    """
    if value < 0 or (value == 0 and not zero):
        raise InvalidParameter(f"{name} must be {'at least' if zero else 'above'} 0, not {value}")
