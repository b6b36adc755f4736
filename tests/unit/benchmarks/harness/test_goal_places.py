"""Places of goals: robots touch no wall there."""

import math
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.fleet.stand_ins.simulation import SPACING, roadmap_of
from benchmarks.harness.halls import goal_in

HALL = roadmap_of("..#.\n....\n#..#")
BLOCKED = [(0, 2), (2, 0), (2, 3), *((row, column) for row in range(-1, 4) for column in (-1, 4))]
BLOCKED += [(row, column) for row in (-1, 3) for column in range(4)]


@given(st.integers(0, len(HALL.roadmap) - 1), st.integers(0, 999), st.floats(0.05, 0.3), st.floats(0.0, 0.5))
def test_a_place_is_in_its_cell_and_off_all_walls(cell: int, seed: int, radius: float, beside: float) -> None:
    x, y = goal_in(cell, HALL, radius, Random(seed), beside)
    centre = HALL.centre(cell)
    assert max(abs(x - centre[0]), abs(y - centre[1])) <= beside * SPACING + 1e-9
    for row, column in BLOCKED:
        dx, dy = (max(abs(a - b * SPACING) - SPACING / 2.0, 0.0) for a, b in ((x, column), (y, row)))
        assert math.hypot(dx, dy) >= radius - 1e-9


def test_the_centre_is_taken_if_no_other_place_is_wanted() -> None:
    assert goal_in(3, HALL, 0.2, Random(1), 0.0) == pytest.approx(HALL.centre(3))
