"""Whether a parameter is a value of its type: what dataclasses of parameters check before their ranges."""

import math

from ppaas.errors import InvalidParameter


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
