"""Frames of clients that may be lost, recognized without their session."""

import cbor2
import pytest

from engine.protocols.session_frames import NumberedFrame
from engine.service.links.carried_session import is_stream

SCAN = {"op": "publish", "topic": "/scan", "msg": {"ranges": [1.0]}}


@pytest.mark.parametrize(
    ("content", "binary"),
    [
        (b'{"op": "publish", "topic": "/scan", "msg": {}}', False),
        (b'{"msg": {"text": "T\xc3\xbcr"}, "topic": "tb1/odom", "op": "publish"}', False),
        (b'{"op": "publish", "topic": "scan", "msg": {}}', True),
        (cbor2.dumps(SCAN), True),
    ],
)
def test_a_scan_in_any_form_is_of_a_stream(content: bytes, binary: bool) -> None:
    assert is_stream(NumberedFrame(1, content, binary))


@pytest.mark.parametrize(
    ("content", "binary"),
    [
        (b'{"op": "subscribe", "topic": "/scan"}', False),
        (b'{"op": "publish", "topic": "goal", "msg": {}}', False),
        (cbor2.dumps(SCAN), False),
        (cbor2.dumps(SCAN | {"topic": "goal"}), True),
        (b'{"op": "publish", "topic": "\xff"}', False),
        (b"\xff", True),
        (b"[]", False),
    ],
)
def test_any_other_frame_must_arrive(content: bytes, binary: bool) -> None:
    assert not is_stream(NumberedFrame(1, content, binary))
