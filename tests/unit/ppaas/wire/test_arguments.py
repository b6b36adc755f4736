"""Arguments of calls: an object, or a list in the order of the fields."""

import json

import pytest

from ppaas.errors import MalformedMessage
from ppaas.messages.base.std_msgs import Bool
from ppaas.messages.nav_msgs import GetPlanRequest
from ppaas.wire.arguments import as_object


def test_object_arguments_are_unchanged() -> None:
    assert as_object(b' {"a":  1}', None) == b' {"a":  1}'


def test_list_arguments_are_matched_with_the_fields_in_order() -> None:
    assert json.loads(as_object(b'[{"x":1},{"y":2}]', GetPlanRequest)) == {"start": {"x": 1}, "goal": {"y": 2}}


@pytest.mark.parametrize("nothing", [b"[]", b" [ ]", b"null"])
def test_empty_or_null_arguments_are_an_empty_object(nothing: bytes) -> None:
    assert as_object(nothing, None) == b"{}"


@pytest.mark.parametrize(
    ("arguments", "kind"), [(b"[true,false]", Bool), (b"[true]", None), (b"1", Bool), (b'"a"', None)]
)
def test_arguments_that_do_not_match_the_fields_are_refused(arguments: bytes, kind: type[Bool] | None) -> None:
    with pytest.raises(MalformedMessage):
        as_object(arguments, kind)
