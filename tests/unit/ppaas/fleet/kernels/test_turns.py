"""Quarter turns agree with their slow twins."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.fleet.kernels.turns import DIRECTIONS, count_quarters, direction, least_quarters, quarters
from ppaas.fleet.roadmap import Roadmap
from tests.reference.fleet import searches
from tests.support.fleet.walks import walks

ROADMAP = Roadmap.of_grid(np.ones((4, 4), np.bool_))
CELLS = st.integers(0, len(ROADMAP) - 1)


@pytest.mark.parametrize("before", range(DIRECTIONS))
@pytest.mark.parametrize("after", range(DIRECTIONS))
def test_quarter_turns_between_directions(before: int, after: int) -> None:
    assert quarters(before, after) == searches.quarters(searches.DIRECTIONS[before], searches.DIRECTIONS[after])


@given(CELLS, st.data())
def test_no_path_has_fewer_quarter_turns_than_the_least(start: int, data: st.DataObject) -> None:
    [path] = data.draw(walks(ROADMAP, [start], 9))
    heading = data.draw(st.integers(0, DIRECTIONS - 1))
    counted = searches.count(ROADMAP, path.tolist())
    assert count_quarters(ROADMAP.cells, path) == counted
    moved = [cell for cell in path if cell != start][:1]
    first = quarters(heading, direction(ROADMAP.cells, start, moved[0])) if moved else 0
    assert least_quarters(ROADMAP.cells, start, heading, path[-1]) <= first + counted


@pytest.mark.parametrize(
    ("heading", "goal", "least"),
    [(0, 5, 0), (0, 13, 0), (1, 9, 1), (2, 9, 2), (0, 10, 1), (1, 10, 1), (2, 10, 2), (3, 10, 2), (3, 4, 0), (1, 4, 2)],
)
def test_least_quarter_turns_from_a_cell(heading: int, goal: int, least: int) -> None:
    assert least_quarters(ROADMAP.cells, 5, heading, goal) == least
