"""Frames that are refused keep what identifies them, within bounds."""

import json

import pytest

from ppaas.wire.operations import CallService, Publish, RefusedOperation
from ppaas.wire.rosbridge import MAX_SHOWN, decode_operation


def refused(frame: str) -> RefusedOperation:
    operation = decode_operation(frame)
    assert isinstance(operation, RefusedOperation)
    return operation


@pytest.mark.parametrize("value", ["Infinity", "1"])
def test_the_operation_id_and_name_of_a_refused_frame_are_known(value: str) -> None:
    frame = refused(f'{{"op":"call_service","service":"/x","id":7,"timeout":"5","args":[{value}]}}')
    assert (frame.op, frame.id, frame.name) == ("call_service", 7, "/x")
    assert "`$.timeout`" in str(frame.error)


@pytest.mark.parametrize("identity", ["1.5", "true", "null", "[1]", "{}", json.dumps("x" * MAX_SHOWN), '"\\ud800"'])
def test_an_id_that_is_no_short_string_or_integer_is_not_sent_back(identity: str) -> None:
    assert refused(f'{{"op":"subscribe","id":{identity}}}').id is None


@pytest.mark.parametrize("frame", ["[]", "[NaN]", "7", "{}", '{"op":null}', '{"op":"' + "x" * 5000 + '"}', "{]"])
def test_a_frame_without_a_known_operation_is_refused_with_a_short_text(frame: str) -> None:
    found = refused(frame)
    assert (found.id, found.name) == (None, "")
    assert len(str(found.error)) < 500


def test_the_content_of_a_valid_frame_is_not_touched() -> None:
    frame = '{"op":"publish","topic":"/a","msg":{"x": 1.50, "x": "\\u0041"}}'
    operation = decode_operation(frame)
    assert isinstance(operation, Publish) and bytes(operation.msg) == b'{"x": 1.50, "x": "\\u0041"}'


@pytest.mark.parametrize(("service", "identity"), [("/a#5", "5"), ("/a#", None), ("/a", None), ("/a#5#6", "5#6")])
def test_an_id_after_the_name_of_a_service_is_its_id_unless_it_has_one(service: str, identity: str | None) -> None:
    operation = decode_operation(json.dumps({"op": "call_service", "service": service}))
    assert isinstance(operation, CallService) and operation.id == identity
    named = decode_operation(json.dumps({"op": "call_service", "service": service, "id": 0}))
    assert isinstance(named, CallService) and named.id == 0
