"""Packed poses of a path."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import MalformedMessage
from ppaas.geometry import poses_along
from ppaas.plans.encoding.codes import pack_poses, unpack_poses
from ppaas.plans.encoding.kernels.grid_moves import MOVES, QUATERNIONS

floats = st.floats(-1e6, 1e6)
tables = st.lists(st.tuples(*[floats] * 7), max_size=12)
in_plane = st.lists(st.tuples(floats, floats), min_size=1, max_size=12)
directions = st.lists(st.integers(0, 7), min_size=1, max_size=40)


def assert_round_trips(poses: np.ndarray) -> bytes:
    packed = pack_poses(poses)
    again = unpack_poses(packed)
    assert again.shape == poses.shape
    assert again.tobytes() == poses.tobytes()
    return packed


@given(tables)
def test_any_poses_round_trip(rows: list[tuple[float, ...]]) -> None:
    assert_round_trips(np.array(rows, np.float64).reshape(-1, 7))


@given(in_plane, floats)
def test_poses_in_the_plane_round_trip(points: list[tuple[float, float]], heading: float) -> None:
    assert_round_trips(poses_along(np.array(points), heading))


@given(directions, st.sampled_from([0.025, 0.05, 0.1]), floats)
def test_a_path_from_cell_to_cell_takes_a_byte_a_pose(turns: list[int], resolution: float, heading: float) -> None:
    poses = np.zeros((len(turns), 7))
    poses[:, :2] = (np.cumsum([(1000, 1000), *MOVES[turns[:-1]].tolist()], axis=0) + 0.5) * resolution
    poses[:, 5:] = QUATERNIONS[turns]
    poses[-1] = poses_along(poses[-1:, :2], heading)[0]
    assert len(assert_round_trips(poses)) <= 3 * 56 + 26 + len(turns)


@given(st.binary(max_size=400))
def test_any_bytes_are_poses_or_refused(data: bytes) -> None:
    try:
        poses = unpack_poses(data)
    except MalformedMessage:
        return
    assert poses.shape[1] == 7
    assert 56 * len(poses) >= min(len(data), 56)


@pytest.mark.parametrize("fault", [lambda data: data[:-1], lambda data: data[:100], lambda data: data + b"x"])
def test_damaged_bytes_are_refused(fault) -> None:
    poses = poses_along(np.cumsum(np.full((20, 2), 0.05), axis=0), 0.3)
    with pytest.raises(MalformedMessage, match="not packed"):
        unpack_poses(fault(pack_poses(poses)))
