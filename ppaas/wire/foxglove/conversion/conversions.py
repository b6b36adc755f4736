"""Conversion of each type, and the pictures that are made of topics."""

from functools import cache
from typing import NamedTuple

from ppaas.wire.foxglove.conversion.base import Conversion
from ppaas.wire.foxglove.conversion.drawn import DRAWN
from ppaas.wire.foxglove.conversion.general import in_cdr, in_json
from ppaas.wire.foxglove.conversion.located import KIND as LOCATED
from ppaas.wire.foxglove.conversion.located import located
from ppaas.wire.foxglove.conversion.scenes import PEOPLE
from ppaas.wire.ros.own_types import has_type


class Picture(NamedTuple):
    """Picture that is made of the messages of a topic, beside the messages themselves.

    ``kind`` is the type of these messages, as spelled in ROS 1, and ``topic`` the topic of the picture.
    """

    kind: str
    topic: str
    conversion: Conversion


PICTURES = {"people": Picture("people_msgs/People", "people/scene", PEOPLE)}
"""Pictures by the topic that they are made of."""


@cache
def conversion_of(kind: str) -> Conversion:
    """Return the conversion of the messages of a type, given as spelled in ROS 1."""
    if kind in DRAWN:
        return DRAWN[kind]
    if kind == LOCATED:
        return located()
    return in_cdr(kind) if has_type(kind) else in_json(kind)
