import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.mapping.closures.kernels import branch_and_bound as kernels
from ppaas.mapping.closures.kernels import pyramid
from tests.reference.mapping import closures as twin

NOTHING = np.zeros(5)
TURNS = np.array([-0.4, 0.0, 0.4])
BLUR = np.array([[80, 120, 80], [120, 255, 120], [80, 120, 80]], np.uint8)

seeds = st.integers(0, 2**32 - 1)


def scene(seed):
    """Return a grid of 20 by 30 cells of 0.1 m, and points that partly lie outside of it."""
    rng = np.random.default_rng(seed)
    corner = np.array([-1.5, -1.0])
    walls = rng.uniform(0.0, 3.0, (25, 2)) + corner
    grid = pyramid.blurred_grid(walls, *corner, 0.1, 20, 30, BLUR)
    return grid, walls, corner, rng.uniform(-1.3, 1.3, (12, 2))


@given(seeds)
def test_blurred_grid_equals_the_twin(seed):
    grid, walls, corner, _ = scene(seed)
    np.testing.assert_array_equal(grid, twin.blurred_grid(walls, *corner, 0.1, 20, 30, BLUR))


@given(seeds, st.integers(1, 6))
def test_best_motion_has_the_largest_sum_of_all(seed, levels):
    grid, _, corner, points = scene(seed)
    half = np.array([9, 6])
    values, sizes = pyramid.build_levels(grid, levels)
    turn, du, dv, total = kernels.best_motion(values, sizes, corner, 0.1, points, TURNS, half, 0, NOTHING)
    scores = twin.all_scores(grid, points, TURNS, half, corner, 0.1)
    assert total == max(scores.values())
    assert total == 0 or scores[turn, du, dv] == total


@given(seeds)
def test_excluded_motions_are_left_out_and_no_others(seed):
    grid, _, corner, points = scene(seed)
    half = np.array([9, 6])
    values, sizes = pyramid.build_levels(grid, 5)
    excluded = np.array([half[0] + 1.0, half[1] - 2.0, 5.0, 0.1, TURNS[1]])
    found = kernels.best_motion(values, sizes, corner, 0.1, points, TURNS, half, 0, excluded)
    scores = twin.all_scores(grid, points, TURNS, half, corner, 0.1)
    others = [s for (a, du, dv), s in scores.items() if a != 1 or math.hypot(du - 1, dv + 2) >= 5.0]
    assert found[3] == max(others)


def test_motion_below_the_least_sum_is_not_found():
    grid, _, corner, points = scene(3)
    values, sizes = pyramid.build_levels(grid, 4)
    least = 255 * len(points)
    found = kernels.best_motion(values, sizes, corner, 0.1, points, TURNS, np.array([5, 5]), least, NOTHING)
    assert found[0] == -1


@pytest.mark.parametrize("level", range(6))
def test_each_level_bounds_the_translations_below_it(level):
    rng = np.random.default_rng(level)
    grid = rng.integers(0, 255, (13, 17)).astype(np.uint8)
    values, sizes = pyramid.build_levels(grid, 6)
    start, height, width = sizes[level]
    bounds = values[start : start + height * width].reshape(height, width)
    edge, shift = 1 << level, pyramid.block_shift(level)
    for v in range(height):
        for u in range(width):
            row, column = (v - pyramid.PADDING) << shift, (u - pyramid.PADDING) << shift
            reach = edge + (1 << shift) - 1
            covered = grid[max(row, 0) : max(row + reach, 0), max(column, 0) : max(column + reach, 0)]
            assert bounds[v, u] >= covered.max(initial=0)
