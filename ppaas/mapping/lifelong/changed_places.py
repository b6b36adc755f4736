"""Places of a map that have changed, and which of them are known."""

import math
from collections.abc import Sequence
from typing import NamedTuple

SAME_PLACE = 0.75
"""Distance of the centres up to which two changes of a kind are the same [m]."""


class ChangedPlace(NamedTuple):
    """Rectangle around cells that have changed, in the map frame.

    Parameters
    ----------
    x, y : float
        Centre [m].
    width, height : float
        Sides [m].
    cells : int
        Number of changed cells in it.
    """

    x: float
    y: float
    width: float
    height: float
    cells: int


Centres = Sequence[tuple[float, float]]
"""Centres x, y of changed places [m]."""


class KnownChanges(NamedTuple):
    """Changes that were proposed before, and are left out.

    Parameters
    ----------
    left, new : sequence of (float, float)
        Centres of the places where something stood, and where something was new [m].
    """

    left: Centres = ()
    new: Centres = ()


NOTHING = KnownChanges()
"""No known changes."""


def centres(places: Sequence[ChangedPlace]) -> list[tuple[float, float]]:
    """Return the centres x, y of places [m]."""
    return [(place.x, place.y) for place in places]


def is_among(place: ChangedPlace, known: Centres) -> bool:
    """Return whether the centre of a place is at one of some others."""
    return any(math.dist((place.x, place.y), centre) <= SAME_PLACE for centre in known)
