"""Paths written as JSON."""

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidInput
from ppaas.messages import decode, encode
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.nav_msgs import Path
from ppaas.planners.kernels.pose_text import BLOCK, MAX_MAGNITUDE, WIDEST, write_rows
from ppaas.planners.path_json import path_message, rows_text
from tests.reference.planners import path

numbers = (
    st.floats(-1e9, 1e9)
    | st.floats(-1e-8, 1e-8)
    | st.floats(-MAX_MAGNITUDE, MAX_MAGNITUDE, exclude_min=True, exclude_max=True)
)
few = st.sampled_from([0.0, -0.0, 1.0, -12.75])
"""Few numbers, so that rows often end like the previous row."""

numbers = numbers | few
tables = st.integers(1, 4).flatmap(
    lambda m: st.lists(st.lists(numbers, min_size=m, max_size=m) | st.lists(few, min_size=m, max_size=m), min_size=1)
)
POSES = np.array(
    [[1.25, -2.5, 0.0, 0.0, 0.0, math.sin(0.4), math.cos(0.4)], [1e6 / 3, -1e-10, 0.0, 0.0, 0.0, -1.0, 0.0]]
)


def written(rows: list[list[float]], pieces: list[str]) -> str:
    each = [piece.encode() for piece in pieces]
    joined = b"".join(each)
    text = np.zeros(len(rows) * (len(joined) + len(rows[0]) * WIDEST) + BLOCK, np.uint8)
    template = np.frombuffer(joined + bytes(BLOCK), np.uint8)
    ends = np.cumsum([len(piece) for piece in each]).astype(np.uint64)
    return text[: int(write_rows(np.array(rows), template, ends, text))].tobytes().decode()


@given(tables, st.lists(st.text("[]{},:x", max_size=20), min_size=5, max_size=5))
def test_kernel_writes_like_its_twin(rows: list[list[float]], pieces: list[str]) -> None:
    used = pieces[: len(rows[0]) + 1]
    assert written(rows, used) == path.rows_text(rows, used)


@given(st.lists(st.lists(st.floats(-1e6, 1e6), min_size=7, max_size=7)))
def test_numbers_round_trip_within_half_a_billionth(rows: list[list[float]]) -> None:
    read = json.loads(rows_text(np.array(rows).reshape(-1, 7)))
    assert len(read) == len(rows)
    np.testing.assert_allclose(np.array(read).reshape(-1, 7), np.array(rows).reshape(-1, 7), rtol=0.0, atol=6e-10)


def test_trailing_zeros_are_omitted() -> None:
    assert json.loads(rows_text(POSES)) == [
        [1.25, -2.5, 0.0, 0.0, 0.0, 0.389418342, 0.921060994],
        [333333.333333333, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0],
    ]
    assert rows_text(POSES[:1]).startswith("[[1.25,-2.5,0.0,0.0,")


def test_path_message_has_ros_form_and_a_header_per_pose() -> None:
    header = Header(7, Time(3, 4), 'the "map"')
    path = decode(Path, encode(path_message(POSES, header)))
    assert path.header == header
    assert [pose.header for pose in path.poses] == [header, header]
    pose = path.poses[0].pose
    assert (pose.position.x, pose.position.y, pose.position.z) == (1.25, -2.5, 0.0)
    assert (pose.orientation.x, pose.orientation.y) == (0.0, 0.0)
    assert (pose.orientation.z, pose.orientation.w) == (0.389418342, 0.921060994)


def test_no_poses_are_an_empty_list() -> None:
    none = np.empty((0, 7))
    assert rows_text(none) == "[]"
    assert decode(Path, encode(path_message(none, Header()))).poses == []


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf, MAX_MAGNITUDE, -1e300])
def test_a_number_out_of_range_is_refused(number: float) -> None:
    poses = POSES.copy()
    poses[1, 1] = number
    with pytest.raises(InvalidInput, match="nearer"):
        rows_text(poses)
