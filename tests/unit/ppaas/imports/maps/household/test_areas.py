import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ppaas.geometry import Pose2D
from ppaas.imports.maps.household.areas import fill_area
from ppaas.maps.grid import GridInfo
from ppaas.polygons import within_polygon

INFO = GridInfo(0.5, 20, 16, Pose2D(-3.0, 2.0, 0.0))
CORNERS = st.lists(st.tuples(st.floats(-10, 15), st.floats(-5, 15)), min_size=3, max_size=3, unique=True)


@given(CORNERS)
def test_cells_within_a_triangle_are_filled_and_none_far_from_it(corners):
    ring, mask = np.array(corners), np.zeros(INFO.shape, np.bool_)
    fill_area(mask, INFO, ring)
    rows, columns = np.mgrid[: INFO.height, : INFO.width]
    centres = INFO.to_world(np.stack((rows, columns), axis=-1).reshape(-1, 2))
    inside = within_polygon(ring, centres).reshape(INFO.shape)
    # Corners are rounded to whole cells, so cells at the outline may differ by one.
    grown = np.pad(inside, 1)
    near = np.any([grown[r : r + INFO.height, c : c + INFO.width] for r in range(3) for c in range(3)], axis=0)
    shrunk = np.pad(inside, 1)
    deep = np.all([shrunk[r : r + INFO.height, c : c + INFO.width] for r in range(3) for c in range(3)], axis=0)
    assert (mask | ~deep).all()
    assert mask[~near].sum() <= 4 * (INFO.width + INFO.height)


def test_an_area_may_be_taken_away_again():
    mask = np.ones(INFO.shape, np.bool_)
    fill_area(mask, INFO, np.array([(-3.0, 2.0), (7.0, 2.0), (7.0, 10.0), (-3.0, 10.0)]), value=False)
    assert not mask.any()
