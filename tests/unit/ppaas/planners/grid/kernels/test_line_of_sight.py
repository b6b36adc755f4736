"""The cells on a line between two centres are exactly those of the twin."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.planners.grid.kernels.line_of_sight import HIDDEN, trace, weigh
from ppaas.planners.watch import proceed
from ppaas.planners.weights import SCALE, blocking_weights, padded
from tests.reference.planners import dijkstra
from tests.support.world import grids


def seen(costs, begin, end, allow_unknown=True):
    """Return the integral that the kernel finds, in whole weights."""
    stride = costs.shape[1] + 2
    cell = (begin[0] + 1) * stride + begin[1] + 1
    weights = blocking_weights(allow_unknown)[0]
    found = weigh(padded(costs, proceed).ravel(), stride, weights, cell, end[0] - begin[0], end[1] - begin[1])
    return math.inf if found == HIDDEN else found / SCALE


def drawn(data, costs):
    return tuple(data.draw(st.integers(0, size - 1)) for size in costs.shape)


@given(grids.cost_arrays(), st.data(), st.booleans())
def test_line_weight_agrees_with_the_twin(costs, data, allow_unknown):
    begin, end = drawn(data, costs), drawn(data, costs)
    assert seen(costs, begin, end, allow_unknown) == pytest.approx(dijkstra.line(costs, begin, end, allow_unknown))


@given(st.integers(0, 5), st.data())
def test_line_weight_is_equal_in_both_directions(seed, data):
    costs = np.random.default_rng(seed).integers(0, 256, (30, 40)).astype(np.uint8)
    costs[costs > 252] = 9
    begin, end = drawn(data, costs), drawn(data, costs)
    assert seen(costs, begin, end) == seen(costs, end, begin)


@given(st.tuples(st.integers(-40, 40), st.integers(-40, 40)))
def test_cells_of_a_line_agree_with_the_twin(over):
    most = abs(over[0]) + abs(over[1])
    cells, points = np.empty((most, 2), np.int32), np.empty((most, 2))
    count = trace(*over, cells, points)
    cells, points = cells[:count], points[:count]
    assert [(0, 0), *map(tuple, cells.tolist())] == [cell for cell, _ in dijkstra.crossed((0, 0), over)[0]]
    assert np.array_equal(np.floor(points + 0.5), cells)
    assert np.abs(points[:, 0] * over[1] - points[:, 1] * over[0]).max(initial=0.0) < 1e-9
    assert not count or tuple(points[-1]) == over


@pytest.mark.parametrize(
    ("picture", "weight"),
    [
        ("..\n..", 50 * math.sqrt(2)),
        (".#\n..", math.inf),
        ("..\n#.", math.inf),
        (".#\n#.", math.inf),
        ("?.\n..", 50 * math.sqrt(2)),
        (".h\n..", 0.5 * (50 + 251.6) * math.sqrt(2)),
    ],
)
def test_line_through_a_corner_needs_four_free_cells(picture, weight):
    assert seen(grids.costmap(picture).data, (0, 0), (1, 1)) == pytest.approx(weight)


def test_a_line_over_32768_columns_is_exact():
    costs = np.full((2, 32_768), 252, np.uint8)
    assert seen(costs, (0, 0), (1, 32_767)) == pytest.approx(251.6 * math.hypot(1, 32_767), rel=1e-12)
    costs[1, 16_384] = 254
    assert seen(costs, (0, 0), (1, 32_767)) == math.inf


def test_the_twin_gives_a_line_computed_by_hand():
    inside, touched = dijkstra.crossed((0, 0), (1, 3))
    assert inside == [((0, 0), 1 / 6), ((0, 1), 1 / 3), ((1, 2), 1 / 3), ((1, 3), 1 / 6)]
    assert sorted(touched) == [(0, 2), (1, 1)]
    assert all(share > 0 for _, share in itertools.chain(inside))
