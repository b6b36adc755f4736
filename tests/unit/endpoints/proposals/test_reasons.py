"""Reasons of proposals."""

from endpoints.proposals.change_watch import MOST_PLACES, reason_of
from endpoints.rest.schemas import MAX_DESCRIPTION
from ppaas.mapping.lifelong.changed_places import ChangedPlace

LEFT, NEW = ChangedPlace(1.25, -0.5, 0.6, 0.4, 24), ChangedPlace(-3.0, 2.0, 0.4, 0.4, 12)


def test_a_reason_says_who_found_what_and_where() -> None:
    assert reason_of("tb1", [LEFT], [NEW, NEW]) == (
        "tb1: two passes show gone: 1 place, 24 cells, 0.60 × 0.40 m at (1.25, -0.50); "
        "new: 2 places, 24 cells, 0.40 × 0.40 m at (-3.00, 2.00), 0.40 × 0.40 m at (-3.00, 2.00)"
    )
    assert reason_of("tb1", [], [NEW]).startswith("tb1: two passes show new: 1 place, ")


def test_a_reason_of_many_changes_fits() -> None:
    far = ChangedPlace(-12345.67, -12345.67, 123.45, 123.45, 99999)
    reason = reason_of("r" * 64, [far] * 50, [far] * 50)
    assert len(reason) <= MAX_DESCRIPTION
    assert f"and {50 - MOST_PLACES} more" in reason
