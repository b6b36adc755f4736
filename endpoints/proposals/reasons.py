"""Reasons of proposals: who found a change, what is gone and what is new; written, and read again."""

import re
from collections.abc import Iterable, Sequence

from ppaas.mapping.lifelong.changes import Centres, ChangedPlace, KnownChanges

MOST_PLACES = 6
"""Largest number of places of a kind that a reason names; it has the numbers of all."""

_PLACE = re.compile(r"m at \((-?\d+\.\d+), (-?\d+\.\d+)\)")

_BEGIN = "{robot}: two passes show "


def reason_of(robot: str, left: Sequence[ChangedPlace], new: Sequence[ChangedPlace]) -> str:
    """Return the reason of a proposal.

    Parameters
    ----------
    robot : str
        Id of the robot.
    left, new : sequence of ChangedPlace
        What is gone, and what is new; the largest first.
    """
    kinds = [f"{name}: {_listed(places)}" for name, places in (("gone", left), ("new", new)) if places]
    return _BEGIN.format(robot=robot) + "; ".join(kinds)


def is_of(robot: str, reason: str) -> bool:
    """Return whether a reason is that of a proposal of a robot."""
    return reason.startswith(_BEGIN.format(robot=robot))


def known_changes(reasons: Iterable[str]) -> KnownChanges:
    """Return the changes that reasons name; texts that are not reasons of proposals name none."""
    left: list[tuple[float, float]] = []
    new: list[tuple[float, float]] = []
    for reason in reasons:
        if _BEGIN.format(robot="") not in reason:
            continue
        before, _, after = reason.partition("new: ")
        left += _centres(before)
        new += _centres(after)
    return KnownChanges(left, new)


def _listed(places: Sequence[ChangedPlace]) -> str:
    named = [f"{one.width:.2f} × {one.height:.2f} m at ({one.x:.2f}, {one.y:.2f})" for one in places[:MOST_PLACES]]
    more = [f"and {len(places) - MOST_PLACES} more"] if len(places) > MOST_PLACES else []
    cells = sum(place.cells for place in places)
    return f"{len(places)} place{'s' * (len(places) > 1)}, {cells} cells, {', '.join([*named, *more])}"


def _centres(text: str) -> Centres:
    return [(float(x), float(y)) for x, y in _PLACE.findall(text)]
