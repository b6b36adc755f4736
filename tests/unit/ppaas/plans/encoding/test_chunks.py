"""Plans are cut by their content, so equal segments are cut equally."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidInput
from ppaas.plans.encoding.chunks import cut_plans, words_of
from ppaas.plans.encoding.granularity import GRANULARITY, inner_granularity
from ppaas.plans.encoding.kernels.chunks import hash_waypoints
from tests.reference.plans import plan_bytes


def poses_of(numbers: list[int]) -> np.ndarray:
    poses = np.zeros((len(numbers), 7))
    poses[:, 0] = numbers
    return poses


def hashes_of(poses: np.ndarray) -> list[int]:
    hashes = np.empty(len(poses), np.uint64)
    assert hash_waypoints(words_of(poses), hashes) == -1
    return hashes.tolist()


def bounds_of(poses: np.ndarray, stops: np.ndarray, granularity: int) -> list[list[int]]:
    cuts = cut_plans(words_of(poses), stops, granularity)
    found, first = [], 0
    for stop in cuts.parts.tolist():
        begins, ends = cuts.begins[first:stop].tolist(), cuts.ends[first:stop].tolist()
        assert begins[1:] == ends[:-1]
        found.append([*begins, *ends[-1:]])
        first = stop
    return [bounds if shared else [] for bounds, shared in zip(found, cuts.shared.tolist(), strict=True)]


@given(st.lists(st.lists(st.integers(0, 20), min_size=1, max_size=80), min_size=1, max_size=5), st.integers(1, 9))
def test_cuts_agree_with_the_twin_for_each_plan(plans: list[list[int]], granularity: int) -> None:
    poses = np.concatenate([poses_of(plan) for plan in plans])
    stops = np.cumsum([len(plan) for plan in plans])
    for plan, stop, bounds in zip(plans, stops.tolist(), bounds_of(poses, stops, granularity), strict=True):
        hashes = [plan_bytes.waypoint_hash(pose) for pose in poses_of(plan).tolist()]
        assert hashes == hashes_of(poses_of(plan))
        assert [at - stop + len(plan) for at in bounds] == plan_bytes.cuts(hashes, granularity)


def test_chunks_are_slightly_longer_than_the_granularity() -> None:
    numbers = np.random.default_rng(1).integers(0, 10**6, 5000).tolist()
    [bounds] = bounds_of(poses_of(numbers), np.array([5000]), 8)
    assert np.diff(bounds).min() >= 8
    assert len(bounds) - 1 <= 5000 / 8
    assert 12 < np.diff(bounds).mean() < 22


def test_shared_segment_is_cut_equally_in_each_plan() -> None:
    random = np.random.default_rng(2)
    one, other, shared = (random.integers(0, 10**6, count).tolist() for count in (100, 57, 300))
    plans = [[*one, *shared, *other], [*other, *shared], shared]
    inside = []
    for plan, begin in zip(plans, (100, 57, 0), strict=True):
        [bounds] = bounds_of(poses_of(plan), np.array([len(plan)]), 8)
        inside.append([at - begin for at in bounds if 20 < at - begin < 280])
    assert inside[0] == inside[1] == inside[2]
    assert len(inside[0]) > 10


def test_hash_depends_on_all_seven_numbers_of_a_pose() -> None:
    poses = np.ones((8, 7))
    poses[np.arange(7), np.arange(7)] = 2.0
    assert len(set(hashes_of(poses))) == 8


def test_non_finite_pose_is_refused() -> None:
    poses = np.zeros((9, 7))
    poses[4, 6] = np.nan
    with pytest.raises(InvalidInput, match="pose 4"):
        cut_plans(words_of(poses), np.array([9]), 2)


@pytest.mark.parametrize("granularity", [-1, 0, 1, 65537])
def test_invalid_granularity_is_refused(granularity: int) -> None:
    with pytest.raises(InvalidInput, match="granularity"):
        inner_granularity(granularity)


def test_plans_are_cut_with_half_of_the_granularity() -> None:
    assert inner_granularity(GRANULARITY) == 8
    assert inner_granularity(3) == 1
