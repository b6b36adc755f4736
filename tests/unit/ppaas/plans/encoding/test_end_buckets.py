"""Buckets miss no plan whose ends are near two positions."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ppaas.plans.encoding.end_buckets import (
    bucket_of_key,
    buckets_near,
    cell_number,
    holds,
    index_keys_of,
    length_of_key,
    may_join,
)
from ppaas.plans.encoding.index_cells import CELL_EDGE, cells_near, cells_touched, scope_of
from tests.reference.plans import plan_bytes

SCOPE = scope_of("house", "v1")
places = st.tuples(
    *[st.floats(-1e6, 1e6) | st.floats(-1e300, 1e300) | st.integers(-40, 40).map(lambda eighth: eighth / 8)] * 2
)
offsets = st.tuples(*[st.floats(-0.5, 0.5)] * 4)
tolerances = st.sampled_from([0.0, 0.1, 0.25, 0.5])


def key_of(scope: bytes, first, last, length: float) -> int:
    [key] = index_keys_of([scope], np.array([(*first, *last)], float), np.array([length], float)).tolist()
    return key


@given(places, places, offsets, tolerances, st.floats(0.0, 1e7))
def test_near_plans_are_in_the_near_buckets(start, goal, offset, tolerance, length) -> None:
    first, last = (start[0] + offset[0], start[1] + offset[1]), (goal[0] + offset[2], goal[1] + offset[3])
    key = key_of(SCOPE, first, last, length)
    assert key == plan_bytes.index_key(SCOPE, (*first, *last), length)
    assert 0 <= key < 2**63
    assert length_of_key(key) == min(int(length * 16), 2**18 - 1)
    near = buckets_near(SCOPE, start, goal, tolerance).tolist()
    assert len(near) <= (81 if tolerance <= 0.25 else 256)
    buckets = [bucket for bucket in near if bucket[0] <= key <= bucket[1]]
    if plan_bytes.near(first, last, start, goal, tolerance):
        assert any(holds(bucket, key) for bucket in buckets)
        assert may_join(np.array([key]), start, goal, tolerance).all()
        assert bucket_of_key(key) in {bucket_of_key(bucket[0]) for bucket in buckets}


def test_most_distant_plans_are_not_in_the_near_buckets() -> None:
    near = buckets_near(SCOPE, (0.25, 0.25), (3.25, 0.25), 0.1).tolist()
    keys = [key_of(SCOPE, (0.25 + dx / 40, 0.25), (3.25, 0.25 + dy / 40), 3.0) for dx in range(10) for dy in range(10)]
    passed = sum(any(each[0] <= key <= each[1] and holds(each, key) for each in near) for key in keys)
    assert 25 <= passed <= 36


@given(st.tuples(*[st.floats(-0.1, 0.1)] * 4), st.tuples(*[st.floats(-20, 20)] * 4))
def test_may_join_agrees_with_the_twin(offset, places) -> None:
    ends = [value + shift for value, shift in zip(places, offset, strict=True)]
    key = key_of(SCOPE, ends[:2], ends[2:], 5.0)
    [joins] = may_join(np.array([key]), tuple(places[:2]), tuple(places[2:]), 0.05).tolist()
    assert joins == plan_bytes.may_join(ends, places, 0.05)


def test_map_versions_have_different_buckets() -> None:
    others = [scope_of("house", "v2"), scope_of("housev", "1"), scope_of("depot", "v1")]
    keys = {bucket_of_key(key_of(scope, (0, 0), (1, 1), 2.0)) for scope in (SCOPE, *others)}
    assert len(keys) == 4


@given(st.tuples(*[st.integers(-(2**40), 2**40)] * 2))
def test_cell_number_is_part_of_the_cells_hash(cell) -> None:
    assert cell_number(SCOPE, cell) == plan_bytes.mixed(SCOPE, cell) >> 33


positions = st.tuples(*[st.floats(-1e6, 1e6) | st.integers(-40, 40).map(lambda eighth: eighth / 8)] * 2)


@given(positions, st.floats(0, 2 * math.pi), st.floats(0, 0.5))
def test_cells_near_a_place_include_those_of_points_in_reach(place, angle, reach) -> None:
    point = place[0] + reach * math.cos(angle), place[1] + reach * math.sin(angle)
    [cell] = cells_touched(np.array([point]))
    near = cells_near(place, 0.5 + 1e-9)
    assert cell in near
    assert len(near) <= math.ceil(1 / CELL_EDGE + 1) ** 2


def test_scopes_of_map_versions_differ() -> None:
    assert len({scope_of("house", "v1"), scope_of("house", "v2"), scope_of("housev", "1")}) == 3
