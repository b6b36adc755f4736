"""Names of sessions and points of resumption, as text and back."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidParameter
from ppaas.wire.resumption import ANEW, ResumptionPoint, parse_name, parse_point


@given(st.text("0123456789abcdef_-", min_size=1, max_size=64), st.integers(0, 10**15 - 1))
def test_resumption_point_round_trips(session: str, received: int) -> None:
    assert parse_point(str(ResumptionPoint(session, received))) == ResumptionPoint(session, received)


def test_a_new_session_has_no_point() -> None:
    assert parse_point(ANEW) is None


@given(st.text())
def test_any_text_is_parsed_or_an_invalid_parameter(text: str) -> None:
    for parse in (parse_name, parse_point):
        try:
            parse(text)
        except InvalidParameter as error:
            assert len(str(error)) < 200


@pytest.mark.parametrize("name", ["", "a b", "a/b", "ä", "x" * 65, "a\n"])
def test_an_invalid_name_is_refused(name: str) -> None:
    with pytest.raises(InvalidParameter, match="1 to 64 letters"):
        parse_name(name)
