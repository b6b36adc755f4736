"""Frames that a client is sent by what its handshake says of it, and content of the messages it sends."""

import pytest
from starlette.datastructures import QueryParams

from endpoints.rosbridge.connect_request import parse_connect_request
from endpoints.rosbridge.robot_socket import content_of, reads_png


@pytest.mark.parametrize("agent", ["AutobahnPython/24.4.2", "Python/3.11 websockets/15.0.1"])
def test_libraries_of_roslibpy_are_not_sent_png(agent: str) -> None:
    assert not reads_png(agent)


@pytest.mark.parametrize("agent", ["", "Mozilla/5.0 (X11; Linux x86_64)", "my robot, as AutobahnPython/1"])
def test_web_pages_and_other_clients_are_sent_png(agent: str) -> None:
    assert reads_png(agent)


@pytest.mark.parametrize(("query", "compact"), [("robot=a", False), ("robot=a&compact=1", True), ("compact=0", False)])
def test_compact_frames_are_asked_for_in_the_address(query: str, compact: bool) -> None:
    assert parse_connect_request(QueryParams(query)).compact is compact


def test_a_message_received_during_the_handshake_is_text_or_bytes() -> None:
    assert content_of({"type": "websocket.receive", "text": ""}) == (b"", False)
    assert content_of({"type": "websocket.receive", "text": "ö"}) == ("ö".encode(), False)
    assert content_of({"type": "websocket.receive", "bytes": b"\xff"}) == (b"\xff", True)
