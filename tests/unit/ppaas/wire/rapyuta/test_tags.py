"""Tags of endpoints and interfaces."""

import pytest

from ppaas.errors import InvalidInput
from ppaas.wire.rapyuta.tags import MAX_TAG, check_tag, split_address


@pytest.mark.parametrize("tag", ["c1", "A_b9", "x", "Z" * MAX_TAG])
def test_a_letter_followed_by_letters_digits_and_underscores_is_a_tag(tag: str) -> None:
    assert check_tag("containerTag", tag) == tag


@pytest.mark.parametrize("tag", ["", "1c", "_c", "a-b", "a/b", "a b", "ä", "a\n", "Z" * (MAX_TAG + 1)])
def test_other_texts_are_no_tags(tag: str) -> None:
    with pytest.raises(InvalidInput, match="is not valid"):
        check_tag("containerTag", tag)


def test_an_address_has_the_tags_of_endpoint_and_interface() -> None:
    assert split_address("tagA", "c1/req") == ("c1", "req")


@pytest.mark.parametrize("text", ["c1", "/req", "c1/", "c1/a/b", ""])
def test_other_texts_are_no_addresses(text: str) -> None:
    with pytest.raises(InvalidInput, match="tagA"):
        split_address("tagA", text)
