"""Base class and checks of the parameters of nodes and plug-ins."""

import math
from collections.abc import Collection
from typing import TypeVar

import msgspec

from ppaas.decoding import converted
from ppaas.errors import InvalidParameter
from ppaas.footprints import read_footprint

FOOTPRINT = "footprint"
"""Name of the parameter that is the outline of the robot, wherever it occurs."""


class Parameters(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Base of a node's parameters: a struct of names, types and defaults, as in ROS."""


P = TypeVar("P", bound=Parameters)


def read_parameters(cls: type[P], node: str, given: object) -> P:
    """Return a node's parameters from a dict decoded from JSON. A ``footprint`` may be text, as in costmap_2d.

    Raises
    ------
    InvalidParameter
        A parameter is unknown, of the wrong type or out of range; the text lists the valid names.
    """
    if isinstance(given, dict) and FOOTPRINT in given:
        given = given | {FOOTPRINT: read_footprint(given[FOOTPRINT])}
    try:
        return converted(given, cls)
    except msgspec.ValidationError as error:
        known = ", ".join(sorted(cls.__struct_fields__))
        raise InvalidParameter(f"parameters of {node!r}: {error}; known: {known}") from error


def check_numbers(parameters: Parameters, *, positive: Collection[str], signed: Collection[str] = ()) -> None:
    """Check that all numbers are finite, and at least 0.

    Parameters
    ----------
    parameters : Parameters
        Their other fields are not checked.
    positive : collection of str
        Names of the parameters that must be above 0.
    signed : collection of str
        Names of the parameters that may be negative.

    Raises
    ------
    InvalidParameter
        A number is not finite or out of range; the text names it.
    """
    for name in parameters.__struct_fields__:
        value = getattr(parameters, name)
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            continue
        if not math.isfinite(value):
            raise InvalidParameter(f"{name} must be finite, not {value}")
        if name not in signed and (value < 0 or (value == 0 and name in positive)):
            raise InvalidParameter(f"{name} must be {'above' if name in positive else 'at least'} 0, not {value}")
