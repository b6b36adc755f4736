"""The cells near a position include those of all positions within the tolerance."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ppaas.plans.encoding.index_cells import CELL_EDGE, cells_near, cells_touched, scope_of

places = st.tuples(*[st.floats(-1e6, 1e6) | st.integers(-40, 40).map(lambda eighth: eighth / 8)] * 2)


@given(places, st.floats(0, 2 * math.pi), st.floats(0, 0.5))
def test_cells_near_a_place_include_those_of_points_in_reach(place, angle, reach) -> None:
    point = place[0] + reach * math.cos(angle), place[1] + reach * math.sin(angle)
    [cell] = cells_touched(np.array([point]))
    near = cells_near(place, 0.5 + 1e-9)
    assert cell in near
    assert len(near) <= math.ceil(1 / CELL_EDGE + 1) ** 2


def test_scopes_of_map_versions_differ() -> None:
    assert len({scope_of("house", "v1"), scope_of("house", "v2"), scope_of("housev", "1")}) == 3
