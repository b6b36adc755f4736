"""Differences between two grids."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.errors import InvalidMap
from ppaas.geometry import Pose2D
from ppaas.maps.formats import map_files
from ppaas.maps.formats.difference import MOST_RECTANGLES, CellCounts, difference, old_rows
from ppaas.maps.formats.map_files import open_grid, save_map
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN, GridInfo, GridMap
from tests.support.budget import examples

cells = st.sampled_from([FREE, OCCUPIED, UNKNOWN])


def opened(data, origin=(0.0, 0.0, 0.0), resolution=0.5):
    data = np.array(data, np.int8)
    info = GridInfo(resolution, data.shape[1], data.shape[0], Pose2D(*origin))
    return open_grid(*save_map(GridMap(data, info), "map.pgm"))


@st.composite
def grids(draw):
    height, width = draw(st.integers(1, 6)), draw(st.integers(1, 6))
    data = draw(st.lists(st.lists(cells, min_size=width, max_size=width), min_size=height, max_size=height))
    column, row = draw(st.integers(-4, 4)), draw(st.integers(-4, 4))
    return data, column, row


@given(grids(), grids(), st.integers(1, 40))
def test_difference_equals_a_comparison_cell_by_cell(old, new, block):
    before, after = ({(c + column, r + row): data[r][c] for r in range(len(data)) for c in range(len(data[0]))}
                     for data, column, row in (old, new))  # fmt: skip
    changed = {at for at in before.keys() | after.keys() if before.get(at, UNKNOWN) != after.get(at, UNKNOWN)}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(map_files, "_BLOCK", block)
        found = difference(*(opened(data, (0.5 * column, 0.5 * row, 0.0)) for data, column, row in (old, new)))
    assert (found.changed, found.aligned) == (len(changed), True)
    if not changed:
        assert (found.rectangle, found.corners) == (None, None)
        return
    left, low = (min(at[axis] for at in changed) for axis in (0, 1))
    right, high = (max(at[axis] for at in changed) + 1 for axis in (0, 1))
    assert found.rectangle == (left - new[1], low - new[2], right - left, high - low)
    covered = {(c, r) for left_, low_, w, h in found.rectangles for c in range(left_, left_ + w)
               for r in range(low_, low_ + h)}  # fmt: skip
    assert {(c - new[1], r - new[2]) for c, r in changed} <= covered
    kinds = [(before.get(at, UNKNOWN), after.get(at, UNKNOWN)) for at in changed]
    became = {kind: sum(now == kind for _, now in kinds) for kind in (OCCUPIED, FREE, UNKNOWN)}
    known = sum(was == UNKNOWN for was, _ in kinds)
    assert found.counts == CellCounts(became[OCCUPIED], became[FREE], known, became[UNKNOWN])
    np.testing.assert_allclose(found.corners[0], [0.5 * left, 0.5 * low], atol=1e-9)
    np.testing.assert_allclose(found.corners[2], [0.5 * right, 0.5 * high], atol=1e-9)


@given(st.sets(st.tuples(st.integers(0, 299), st.integers(0, 299)), min_size=1, max_size=60))
@settings(max_examples=examples(25))
def test_few_rectangles_cover_all_changed_cells(changed):
    before = np.zeros((300, 300), np.int8)
    after = before.copy()
    after[tuple(np.array(list(changed)).T)] = OCCUPIED
    found = difference(opened(before), opened(after))
    covered = np.zeros(before.shape, int)
    for column, row, width, height in found.rectangles:
        covered[row : row + height, column : column + width] += 1
    assert len(found.rectangles) <= MOST_RECTANGLES
    assert covered.max() == 1
    assert covered[before != after].all()
    if len(changed) == 1:
        assert found.rectangles == [found.rectangle]


def test_a_turned_map_is_compared_in_its_own_frame():
    origin = (1.0, 2.0, np.pi / 2)
    found = difference(opened([[0, 0, 0]], origin), opened([[0, 0, 100]], origin))
    assert found.rectangle == (2, 0, 1, 1)
    np.testing.assert_allclose(found.corners, [[1.0, 3.0], [1.0, 3.5], [0.5, 3.5], [0.5, 3.0]], atol=1e-9)


@pytest.mark.parametrize(
    ("origin", "resolution"),
    [((0.0, 0.0, 0.0), 0.25), ((0.2, 0.0, 0.0), 0.5), ((0.0, 0.0, 0.1), 0.5), ((1e300, 0.0, 0.0), 0.5)],
)
def test_unaligned_maps_differ_in_all_cells(origin, resolution):
    old, new = opened([[0, 0]]), opened([[0, 0, 0], [0, 0, 0]], origin, resolution)
    found = difference(old, new)
    assert (found.changed, found.rectangle, found.aligned) == (6, (0, 0, 3, 2), False)
    with pytest.raises(InvalidMap, match="cannot be compared"):
        old_rows(old, new.info, 0, 1)


def test_distant_maps_are_compared_in_bounded_memory():
    found = difference(opened([[0, 100]]), opened([[100]], (1e9, -1e9, 0.0)))
    assert found.changed == 3
    assert found.rectangle == (-2_000_000_000, 0, 2_000_000_001, 2_000_000_001)
