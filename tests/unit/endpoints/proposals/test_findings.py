"""Findings of robots in the reviews of a map, and the reasons of proposals."""

from endpoints.proposals.change_watch import MOST_PLACES, confirmed_places, known_changes, reason_of, waits
from endpoints.rest.schemas import MAX_DESCRIPTION
from engine.control.views import LifelongRobot
from ppaas.mapping.lifelong.changed_places import ChangedPlace
from storage.records import MapReview, ProposedChange, ReviewState

LEFT, NEW = ChangedPlace(1.251, -0.5, 0.6, 0.4, 24), ChangedPlace(-3.0, 2.0, 0.4, 0.4, 12)


def review(left: list[ChangedPlace], new: list[ChangedPlace], state: ReviewState = "waiting") -> MapReview:
    change = ProposedChange(confirmed=confirmed_places("tb1", left, new))
    return MapReview(1, "b", "a", 0.0, "ann", "a chair", change=change, state=state)


PERSONS = MapReview(2, "c", "a", 0.0, "ann", "tb1: two passes show gone: 1 place, 1.00 × 1.00 m at (1.00, 2.00)")
"""Proposal of a user, whose text is that of a robot."""


def test_places_that_wait_or_were_refused_are_known() -> None:
    known = known_changes([review([LEFT], [NEW]), review([], [LEFT], "refused"), review([NEW], [], "approved")])
    assert (known.left, known.new) == ([(1.25, -0.5)], [(-3.0, 2.0), (1.25, -0.5)])


def test_texts_of_users_name_no_places() -> None:
    assert known_changes([PERSONS]) == ([], [])
    assert not waits([PERSONS], LifelongRobot("ann", "tb1", "office"))


def test_a_proposal_waits_for_the_robot_of_its_author_only() -> None:
    waiting = review([LEFT], [])
    assert waits([PERSONS, waiting], LifelongRobot("ann", "tb1", "office"))
    assert not waits([waiting], LifelongRobot("ann", "tb2", "office"))
    assert not waits([waiting], LifelongRobot("bob", "tb1", "office"))
    assert not waits([review([LEFT], [], "refused")], LifelongRobot("ann", "tb1", "office"))


GONE, FOUND = ChangedPlace(1.25, -0.5, 0.6, 0.4, 24), ChangedPlace(-3.0, 2.0, 0.4, 0.4, 12)


def test_a_reason_says_who_found_what_and_where() -> None:
    assert reason_of("tb1", [GONE], [FOUND, FOUND]) == (
        "tb1: two passes show gone: 1 place, 24 cells, 0.60 × 0.40 m at (1.25, -0.50); "
        "new: 2 places, 24 cells, 0.40 × 0.40 m at (-3.00, 2.00), 0.40 × 0.40 m at (-3.00, 2.00)"
    )
    assert reason_of("tb1", [], [FOUND]).startswith("tb1: two passes show new: 1 place, ")


def test_a_reason_of_many_changes_fits() -> None:
    far = ChangedPlace(-12345.67, -12345.67, 123.45, 123.45, 99999)
    reason = reason_of("r" * 64, [far] * 50, [far] * 50)
    assert len(reason) <= MAX_DESCRIPTION
    assert f"and {50 - MOST_PLACES} more" in reason
