"""Findings of robots in the reviews of a map: written with a proposal, and read so that none is proposed again."""

from collections.abc import Iterable, Sequence

from engine.service.views import LifelongRobot
from ppaas.mapping.lifelong.changed_places import ChangedPlace, KnownChanges, centres
from storage.records import ConfirmedPlaces, MapReview


def confirmed_places(robot: str, left: Sequence[ChangedPlace], new: Sequence[ChangedPlace]) -> ConfirmedPlaces:
    """Return what a review stores of the places that a robot found gone and new.

    The search for changes bounds their number: each entry of a map's log has the places of all its reviews.
    """
    return ConfirmedPlaces(robot, _rounded(left), _rounded(new))


def waits(reviews: Iterable[MapReview], robot: LifelongRobot) -> bool:
    """Return whether a proposal of a robot waits for its review."""
    return any(
        review.waits and review.author == robot.user and confirmed.robot == robot.robot
        for review in reviews
        if (confirmed := review.change.confirmed) is not None
    )


def known_changes(reviews: Iterable[MapReview]) -> KnownChanges:
    """Return the changes that robots have proposed and that wait or were refused."""
    found = [
        confirmed
        for review in reviews
        if review.state != "approved" and (confirmed := review.change.confirmed) is not None
    ]
    return KnownChanges([place for one in found for place in one.left], [place for one in found for place in one.new])


def _rounded(places: Sequence[ChangedPlace]) -> tuple[tuple[float, float], ...]:
    """Return the centres of places, rounded to centimetres."""
    return tuple((round(x, 2), round(y, 2)) for x, y in centres(places))
