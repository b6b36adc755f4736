"""Frames of many robots in one tree."""

from hypothesis import given
from hypothesis import strategies as st

from ppaas.wire.foxglove.conversion.base import SharedFrames

ON_MAP, ALONE = SharedFrames("tb1", "office"), SharedFrames("ann/tb1")
NAMES = st.text("abz_/", min_size=1, max_size=8).map(lambda name: name.strip("/")).filter(bool)


def test_robots_of_a_map_share_its_frame() -> None:
    assert [ON_MAP.shared(frame) for frame in ("map", "/map", "odom", "")] == ["office", "office", "tb1/odom", ""]
    assert [ALONE.shared(frame) for frame in ("map", "odom")] == ["ann/tb1/map", "ann/tb1/odom"]
    assert ON_MAP.shared("tb1/torso_3") == "tb1/torso_3"


@given(NAMES)
def test_a_frame_of_the_tree_is_that_of_the_robot(name: str) -> None:
    for frames in (ON_MAP, ALONE):
        if not name.startswith(f"{frames.robot}/") and name != frames.map:
            assert frames.own(frames.shared(name)) == name


def test_all_frames_of_a_message_are_renamed() -> None:
    message = {
        "header": {"frame_id": "map", "stamp": {"secs": 1}},
        "poses": [{"header": {"frame_id": "odom"}}, {"child_frame_id": "base_link", "ranges": [1.0]}],
        "names": ["map"],
        "frame_id": 7,
    }
    ON_MAP.share_all(message)
    assert message == {
        "header": {"frame_id": "office", "stamp": {"secs": 1}},
        "poses": [{"header": {"frame_id": "tb1/odom"}}, {"child_frame_id": "tb1/base_link", "ranges": [1.0]}],
        "names": ["map"],
        "frame_id": 7,
    }
    ON_MAP.own_all(message)
    assert message["header"] == {"frame_id": "map", "stamp": {"secs": 1}}
