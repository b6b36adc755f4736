"""Names of frames in messages of clients."""

import json

import pytest

from ppaas.errors import MalformedMessage, NotFound
from ppaas.messages import decode
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import TransformStamped
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.transforms.connections import not_connected

HOSTILE = ["x\ny", "x\x1b[31m", "\x00", "x\x7f", "x\x85y", "x\u2028y", "x\n", "x" * 256]


@pytest.mark.parametrize("name", HOSTILE)
@pytest.mark.parametrize("spelling", [{"secs": 1}, {"sec": 1, "nanosec": 2}])
def test_names_with_control_characters_are_refused_with_their_place(name: str, spelling: dict[str, int]) -> None:
    header = {"stamp": spelling, "frame_id": name}
    for kind, message, place in (
        (Header, header, "$.frame_id"),
        (Odometry, {"header": header}, "$.header.frame_id"),
        (TransformStamped, {"child_frame_id": name}, "$.child_frame_id"),
        (TFMessage, {"transforms": [{"header": header}]}, "$.transforms[0].header.frame_id"),
    ):
        with pytest.raises(MalformedMessage, match="the name of a frame has") as refused:
            decode(kind, json.dumps(message).encode())
        assert f"`{place}`" in str(refused.value)
        assert str(refused.value).isprintable()


@pytest.mark.parametrize("name", ["", "base_link", "/tb3_1/base_link", "a b", "laser-1.2", "Größe", "前", "x" * 255])
def test_names_that_tf2_takes_are_taken(name: str) -> None:
    assert decode(Header, json.dumps({"frame_id": name}).encode()).frame_id == name


def test_names_in_lists_are_quoted_where_they_could_be_taken_for_text() -> None:
    error = not_connected("map", "nowhere", ["base_link", "a, b", "x\ny"])
    assert str(error) == "unknown frame 'map' and 'nowhere'; known: base_link, 'a, b', 'x\\ny'"
    assert str(NotFound("node", "x", ["b\x1b", "a"])) == "unknown node 'x'; known: a, 'b\\x1b'"
