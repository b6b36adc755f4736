"""Parsers of bounded numbers: they return the number, or an error that states the bounds."""

import pytest

from ppaas.bounded import above_zero, whole
from ppaas.errors import InvalidParameter


def test_integers_within_bounds_are_parsed() -> None:
    assert [whole()("1"), whole(0, 9)("0"), whole(most=9)("9"), whole(100)("1000000")] == [1, 0, 9, 1_000_000]


@pytest.mark.parametrize("text", ["0", "10", "-3", "1.5", "", "two", "1e1", "٣x"])
def test_other_text_than_an_integer_within_bounds_is_refused(text: str) -> None:
    with pytest.raises(InvalidParameter, match=r"whole number from 1 to 9, not"):
        whole(most=9)(text)
    with pytest.raises(InvalidParameter, match=r"whole number of at least 100, not"):
        whole(100)(text)


@pytest.mark.parametrize("text", ["0", "-1", "nan", "inf", "61", "soon"])
def test_number_must_be_positive_and_within_its_bound(text: str) -> None:
    assert above_zero(60)("0.5") == 0.5
    with pytest.raises(InvalidParameter, match="above 0 and up to 60, not"):
        above_zero(60)(text)
