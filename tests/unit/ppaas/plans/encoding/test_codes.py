"""Segments of waypoints survive encoding bit for bit."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import Unavailable
from ppaas.plans.encoding.codes import codes_of, entry_id, pack, poses_in, poses_of, unpack, waypoints_in
from ppaas.plans.encoding.kernels.grid_moves import MOVES, QUATERNIONS
from tests.reference.plans import plan_bytes

directions = st.lists(st.integers(0, 7), min_size=1, max_size=60)
floats = st.floats(allow_nan=False, allow_infinity=False)


def on_grid(directions: list[int], resolution: float, origin: tuple[float, float], cell: tuple[int, int]) -> np.ndarray:
    """Return the poses of moves between the centres of cells, as planners make them."""
    cells = np.cumsum([cell, *MOVES[directions[:-1]].tolist()], axis=0)
    poses = np.zeros((len(directions), 7))
    poses[:, :2] = (cells + 0.5) * resolution + origin
    poses[:, 5:] = QUATERNIONS[directions]
    return poses


def code_of(poses: np.ndarray) -> bytes:
    [code] = codes_of(poses, np.array([0]), np.array([len(poses)]))
    return code


def assert_round_trips(poses: np.ndarray) -> bytes:
    code = code_of(poses)
    chain = plan_bytes.chain(poses.tolist())
    assert code == chain if chain is not None else code[:1] != b"\x01"
    assert poses_of(code).tobytes() == poses.tobytes()
    assert unpack(pack(code)) == code
    assert waypoints_in(code) == len(poses)
    return code


@given(
    directions,
    st.sampled_from([0.025, 0.05, 0.1, 1.0]),
    st.tuples(floats, floats).map(lambda origin: tuple(round(value % 1000.0, 6) for value in origin)),
    st.tuples(st.integers(-3000, 3000), st.integers(-3000, 3000)),
)
def test_grid_paths_round_trip(directions, resolution, origin, cell) -> None:
    assert_round_trips(on_grid(directions, resolution, origin, cell))


def test_grid_path_takes_about_three_bits_a_waypoint() -> None:
    random = np.random.default_rng(1)
    code = assert_round_trips(on_grid(random.integers(0, 8, 800).tolist(), 0.5, (0.0, 0.0), (10, 20)))
    assert len(pack(code)) < 800 * 3 / 8 + 30
    code = assert_round_trips(on_grid(random.integers(0, 8, 800).tolist(), 0.05, (-51.224998, 3.3), (10, 20)))
    assert len(pack(code)) < 800 * 7 / 8 + 30


@given(st.lists(st.tuples(*[floats] * 7), min_size=1, max_size=30))
def test_any_poses_round_trip(rows) -> None:
    assert_round_trips(np.array(rows))


@given(
    directions.filter(lambda directions: len(directions) > 2),
    st.integers(0, 59),
    st.integers(0, 6),
    st.sampled_from([-1, 1, 5, 1 << 40]),
)
def test_path_off_the_grid_round_trips(directions, row, column, places) -> None:
    poses = on_grid(directions, 0.05, (0.0, 0.0), (100, 100))
    words = poses.view(np.int64)
    words[row % len(poses), column] += places
    assert_round_trips(poses)


def test_path_with_steps_of_different_lengths_round_trips() -> None:
    poses = on_grid([0] * 20, 0.05, (0.0, 0.0), (0, 0))
    poses[10:, 0] += 0.05
    assert_round_trips(poses)


def test_segments_of_all_kinds_are_decoded_together() -> None:
    random = np.random.default_rng(3)
    flat = on_grid([1, 2, 3], 0.05, (0.0, 0.0), (1, 1)) * 1.1
    beside = on_grid(random.integers(0, 8, 30).tolist(), 0.05, (-51.224998, 3.3), (10, 20))
    parts = [on_grid([0, 1, 2] * 5, 0.5, (0.0, 0.0), (3, 4)), random.random((9, 7)), flat, beside, parts_of_one()]
    packs = [pack(code_of(part)) for part in parts]
    assert poses_in(packs).tobytes() == np.concatenate(parts).tobytes()
    assert poses_in([]).shape == (0, 7)


def parts_of_one() -> np.ndarray:
    return on_grid([4], 0.05, (0.0, 0.0), (7, 7))


def test_equal_segments_have_equal_codes_in_any_plan() -> None:
    segment = on_grid([0, 1, 2, 2, 3, 4, 0, 0, 7] * 3, 0.05, (-1.0, -2.0), (40, 30))
    other = np.random.default_rng(1).random((5, 7))
    poses = np.concatenate((other, segment, other, segment))
    begins, ends = np.array([0, 5, 32, 37]), np.array([5, 32, 37, 64])
    codes = codes_of(poses, begins, ends)
    assert codes[1] == codes[3]
    assert codes[0] == codes[2]
    assert entry_id(bytes(16), codes[0]) != entry_id(b"other scope.....", codes[0])


def test_smooth_path_is_smaller_than_raw() -> None:
    angle = np.linspace(0, 3, 200)
    poses = np.zeros((200, 7))
    poses[:, 0], poses[:, 1] = np.round(10 * np.cos(angle) * 1024) / 1024, np.round(10 * np.sin(angle) * 1024) / 1024
    poses[:, 6] = 1.0
    code = assert_round_trips(poses)
    assert len(pack(code)) < poses.nbytes / 8


@pytest.mark.parametrize("data", [b"", b"\x00", b"\x01", b"\x01\x00abc", b"\x02abc", b"\x03" + bytes(9), b"\xff"])
def test_damaged_bytes_are_refused(data: bytes) -> None:
    with pytest.raises(Unavailable, match="backup"):
        poses_of(unpack(data))
