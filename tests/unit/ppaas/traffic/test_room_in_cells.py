"""Room of robots in cells: two that stop in cells side by side keep apart."""

import math

from hypothesis import given
from hypothesis import strategies as st

from ppaas.traffic.room_in_cells import beside, nearest_in_cell

PLACES = st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))


@given(PLACES, st.floats(0.3, 1.0), st.floats(0.0, 1.2))
def test_the_place_in_a_cell_is_the_nearest_one(place: tuple[float, float], spacing: float, radius: float) -> None:
    apart = beside(spacing, radius)
    x, y = nearest_in_cell(place, (0.5, -0.5), apart)
    assert max(abs(x - 0.5), abs(y + 0.5)) <= apart + 1e-12
    if max(abs(place[0] - 0.5), abs(place[1] + 0.5)) <= apart:
        assert (x, y) == place


@given(PLACES, PLACES, st.floats(0.1, 0.4), st.floats(0.0, 0.3))
def test_two_robots_in_cells_side_by_side_keep_a_margin(
    one: tuple[float, float], other: tuple[float, float], radius: float, margin: float
) -> None:
    spacing = 2.0 * (radius + margin)
    here, there = [
        nearest_in_cell(place, (x, 0.0), beside(spacing, radius)) for place, x in ((one, 0.0), (other, spacing))
    ]
    assert math.dist(here, there) >= 2.0 * radius + margin - 1e-9
