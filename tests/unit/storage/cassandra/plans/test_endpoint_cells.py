"""Buckets and cells miss no plan whose ends are near two places, and admit few others."""

import math
from collections import namedtuple

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from storage.cassandra.plans.endpoint_cells import NearbyBuckets, cell_key, length_of_cell, quantized_length
from storage.plan_query import PlanStoreQuery
from storage.records import PlanRecord
from tests.support.storage.records import plan

Row = namedtuple("Row", ["bucket", "spot"])

places = st.tuples(*[st.floats(-1e300, 1e300) | st.floats(-1e3, 1e3) | st.integers(-40, 40).map(lambda n: n / 8)] * 2)
offsets = st.tuples(*[st.floats(-0.5, 0.5)] * 4)
tolerances = st.sampled_from([0.0, 0.1, 0.25, 0.5])


def between(first: tuple[float, float], last: tuple[float, float], length: float = 5.0) -> PlanRecord:
    poses = np.zeros((2, 7))
    poses[:, :2] = first, last
    return plan("p", map="house", version="v", poses=poses.tobytes(), length=length)


@given(places, places, offsets, tolerances)
def test_plans_near_both_places_are_found_and_few_others(start, goal, off, tolerance) -> None:
    first, last = (start[0] + off[0], start[1] + off[1]), (goal[0] + off[2], goal[1] + off[3])
    bucket, spot, _ = cell_key(between(first, last))
    buckets = NearbyBuckets(PlanStoreQuery("house", "v", start, goal, tolerance))
    assert len(buckets.ids) == len(set(buckets.ids)) <= 81
    joins = bucket in buckets.ids and buckets.connecting([Row(bucket, spot)]) == [(bucket, spot)]
    apart = max(math.dist(first, start), math.dist(last, goal))
    if apart <= tolerance:
        assert joins
    if max(map(abs, (*first, *last))) < 1e4 and apart > tolerance + math.sqrt(2.0) / 64 + 1e-6:
        assert not joins


@given(st.floats(0.0, 1e12), st.floats(0.0, 1e12))
def test_shorter_plans_come_first(one, other) -> None:
    cells = [cell_key(between((0.5, 0.5), (3.5, 0.5), length))[1] for length in (one, other)]
    assert [length_of_cell(spot) for spot in cells] == [quantized_length(one), quantized_length(other)]
    assert all(0 <= spot < 2**63 for spot in cells)
    if quantized_length(one) < quantized_length(other):
        assert cells[0] < cells[1]


def test_lengths_are_rounded_down_to_a_16th_of_a_metre() -> None:
    assert [quantized_length(length) for length in (0.0, 0.0624, 0.0625, 1.0, 1e9)] == [0, 0, 1, 16, 2**18 - 1]


def test_versions_of_maps_share_no_bucket() -> None:
    one = between((0.5, 0.5), (3.5, 0.5))
    poses = {"poses": one.poses}
    others = [plan("p", map="house", version="w", **poses), plan("p", map="housev", version="", **poses)]
    assert len({cell_key(each)[0] for each in (one, *others)}) == 3


def test_plans_of_other_planners_or_parameters_are_in_other_cells() -> None:
    one = between((0.5, 0.5), (3.5, 0.5))
    others = [plan("p", map="house", version="v", poses=one.poses, length=5.0, **how) for how in (
        {}, {"planner": "jps"}, {"parameters": {"robot_radius": 0.3}},
    )]  # fmt: skip
    assert len({cell_key(each)[0] for each in others}) == 1
    assert [cell_key(each)[1] == cell_key(one)[1] for each in others] == [True, False, False]


def test_an_empty_list_of_cells_has_no_candidates() -> None:
    assert NearbyBuckets(PlanStoreQuery("house", "v", (0.0, 0.0), (1.0, 0.0), 0.1)).connecting([]) == []
