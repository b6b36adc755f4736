"""Corners and visibility match the definitions."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from ppaas.planners.hub_labels.building.graph import build_corner_graph, build_corner_map
from ppaas.planners.hub_labels.kernels.bits import down, up
from ppaas.planners.hub_labels.kernels.scan import DIAGONAL, STRAIGHT, most_seen, scan
from ppaas.planners.watch import proceed
from tests.reference.planners import hub_labels as twin


def maps(most: int = 11) -> st.SearchStrategy:
    """Draw small maps, mostly open ones."""
    shapes = st.tuples(st.integers(1, most), st.integers(1, most))
    return shapes.flatmap(lambda shape: st.one_of(*(_filled(shape, free) for free in (0.5, 0.8, 0.95))))


def _filled(shape: tuple[int, int], free: float) -> st.SearchStrategy:
    seeds = st.integers(0, 2**32 - 1)
    return seeds.map(lambda seed: np.random.default_rng(seed).random(shape) < free)


def in_whole_numbers(a, b) -> int:
    rows, columns = abs(a[0] - b[0]), abs(a[1] - b[1])
    return STRAIGHT * abs(rows - columns) + DIAGONAL * min(rows, columns)


@given(hnp.arrays(np.int64, 6), st.integers(0, 127), st.integers(0, 140))
def test_set_bits_are_counted_in_both_directions(words, bit, most):
    for stride in (1, 2, 3):
        line = words[::stride]
        bits = [bool((int(line[i // 64]) >> (i % 64)) & 1) for i in range(64 * len(line))]
        if bit + most < len(bits):
            assert up(words, 0, stride, bit, most) == next((i for i in range(most) if bits[bit + i]), most)
        if bit < len(bits) and bit - most >= -1:
            assert down(words, 0, stride, bit, most) == next((i for i in range(most) if bits[bit - i]), most)


@given(maps())
def test_corners_seen_from_each_free_cell_agree_with_the_twin(free):
    corner_map = build_corner_map(free, threads=1, check=proceed)
    corners = [(int(r) - 1, int(c) - 1) for r, c in corner_map.positions]
    assert corners == twin.corners(free)
    most = most_seen(free.shape[0] + 2, free.shape[1] + 2, len(corners))
    seen, lengths = np.empty((2, most), np.int32)
    for cell in zip(*np.nonzero(free), strict=True):
        found = scan(corner_map.terrain, cell[0] + 1, cell[1] + 1, seen, lengths)
        assert {corners[i] for i in seen[:found]} == twin.seen(free, cell)
        assert len(set(seen[:found])) == found
        assert lengths[:found].tolist() == [in_whole_numbers(cell, corners[i]) for i in seen[:found]]


@pytest.mark.parametrize("blocked", [0.02, 0.3])
def test_corner_graph_is_symmetric_on_any_number_of_threads(blocked):
    free = np.random.default_rng(3).random((150, 333)) >= blocked
    corner_maps = [build_corner_map(free, threads=threads, check=proceed) for threads in (1, 2)]
    np.testing.assert_array_equal(corner_maps[0].terrain, corner_maps[1].terrain)
    one, two = (build_corner_graph(corner_maps[0], threads=threads, check=proceed) for threads in (1, 2))
    for name in ("starts", "to", "lengths"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))
    source = np.repeat(np.arange(len(one.starts) - 1), np.diff(one.starts))
    pairs = set(zip(source.tolist(), one.to.tolist(), one.lengths.tolist(), strict=True))
    assert pairs == {(b, a, length) for a, b, length in pairs}
