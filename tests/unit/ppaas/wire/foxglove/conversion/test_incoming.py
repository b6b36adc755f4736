"""Messages that Foxglove's clients publish."""

import json

from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidInput, PPaaSError
from ppaas.messages import decode, encode
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point, Pose, PoseStamped, Quaternion
from ppaas.wire.foxglove.conversion.base import SharedFrames
from ppaas.wire.foxglove.conversion.incoming import read_published
from ppaas.wire.ros import ros_types

FRAMES = SharedFrames("tb1", "office")
KIND = "geometry_msgs/PoseStamped"
NUMBERS = st.floats(-1e6, 1e6)


@given(NUMBERS, NUMBERS, st.integers(0, 2**31 - 1), st.sampled_from(["json", "cdr", "ros1"]))
def test_a_message_is_the_same_in_each_encoding(x: float, y: float, secs: int, encoding: str) -> None:
    shared = PoseStamped(Header(0, Time(secs, 1), "office"), Pose(Point(x, y), Quaternion(z=0.0, w=1.0)))
    text = encode(shared)
    data = (
        text if encoding == "json" else ros_types({"cdr": "jazzy", "ros1": "noetic"}[encoding]).encode_json(KIND, text)
    )
    found = decode(PoseStamped, read_published(encoding, KIND, data, FRAMES))
    assert (found.header.frame_id, found.header.stamp, found.pose) == ("map", Time(secs, 1), shared.pose)


def test_times_of_foxglove_are_read() -> None:
    sent = {"header": {"stamp": {"sec": 1, "nsec": 2}}, "list": [{"sec": 3, "nsec": 4}], "sec": 5}
    found = json.loads(read_published("json", KIND, json.dumps(sent).encode(), FRAMES))
    assert found == {
        "header": {"stamp": {"secs": 1, "nsecs": 2}},
        "list": [{"secs": 3, "nsecs": 4}],
        "sec": 5,
    }


@given(st.sampled_from(["json", "cdr", "ros1"]), st.sampled_from([KIND, "no/Such", "sensor_msgs/LaserScan"]),
       st.binary(max_size=80))  # fmt: skip
def test_any_bytes_are_read_or_refused(encoding: str, kind: str, data: bytes) -> None:
    try:
        read_published(encoding, kind, data, FRAMES)
    except PPaaSError as error:
        assert isinstance(error, InvalidInput)
