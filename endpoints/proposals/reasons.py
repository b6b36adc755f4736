"""Reasons of proposals: which robot found a change, what is gone and what is new."""

from collections.abc import Sequence

from ppaas.mapping.lifelong.changed_places import ChangedPlace

MOST_PLACES = 6
"""Largest number of places of a kind that a reason names; it gives the number of all."""


def reason_of(robot: str, left: Sequence[ChangedPlace], new: Sequence[ChangedPlace]) -> str:
    """Return the reason of a proposal.

    Parameters
    ----------
    robot : str
        Id of the robot.
    left, new : sequence of ChangedPlace
        Places where something is gone, and places where something is new; the largest first.
    """
    kinds = [f"{name}: {_listed(places)}" for name, places in (("gone", left), ("new", new)) if places]
    return f"{robot}: two passes show {'; '.join(kinds)}"


def _listed(places: Sequence[ChangedPlace]) -> str:
    named = [f"{one.width:.2f} × {one.height:.2f} m at ({one.x:.2f}, {one.y:.2f})" for one in places[:MOST_PLACES]]
    more = [f"and {len(places) - MOST_PLACES} more"] if len(places) > MOST_PLACES else []
    cells = sum(place.cells for place in places)
    return f"{len(places)} place{'s' * (len(places) > 1)}, {cells} cells, {', '.join([*named, *more])}"
