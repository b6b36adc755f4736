import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.navigation.barn.scan_matching import ARC, DEPTH, MOST, smoothed
from ppaas.costmap.obstacle_layer import LaserReading
from ppaas.geometry import Pose2D

SPACING = math.radians(270.0) / 719
SOME = st.one_of(st.floats(0.05, 10.0), st.sampled_from([math.nan, math.inf, 0.0]))


def reading(ranges):
    return LaserReading(Pose2D(0.0, 0.0), SPACING * np.arange(len(ranges)), np.array(ranges, dtype=np.float64))


def naive(ranges):
    """Return the smoothed ranges, beam by beam."""
    found = list(ranges)
    for i, middle in enumerate(ranges):
        if not (math.isfinite(middle) and middle > 0.0):
            continue
        reach = min(MOST, math.floor(ARC / (middle * SPACING)))
        beside = ranges[max(i - reach, 0) : i + reach + 1]
        found[i] = np.mean([r for r in beside if math.isfinite(r) and r > 0.0 and abs(r - middle) <= DEPTH])
    return found


@given(st.lists(SOME, min_size=0, max_size=40))
def test_each_range_is_the_mean_of_its_neighbours_on_the_same_surface(ranges):
    assert smoothed(reading(ranges)).ranges == pytest.approx(naive(ranges), nan_ok=True, rel=1e-9)


def test_smoothing_removes_noise_of_a_near_surface():
    noisy = 0.5 + np.random.default_rng(1).normal(0.0, 0.02, 200)
    assert noisy.min() < 0.46
    assert np.abs(smoothed(reading(noisy)).ranges - 0.5).max() < 0.02


def test_ranges_are_not_averaged_across_an_edge():
    ranges = [0.6] * 30 + [2.0] * 30 + [math.inf] * 10
    assert smoothed(reading(ranges)).ranges == pytest.approx(ranges)


def test_ranges_are_unchanged_where_a_beam_is_wider_than_the_arc():
    ranges = [9.0, 9.05, 8.97, 9.02]
    assert smoothed(reading(ranges)).ranges.tolist() == ranges
