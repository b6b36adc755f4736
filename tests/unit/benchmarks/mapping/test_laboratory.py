import itertools

import numpy as np
import pytest

from benchmarks.mapping.laboratory import CORRIDOR, laboratory
from benchmarks.mapping.simulated_drive import cast, drive


@pytest.mark.parametrize("seed", [0, 1])
def test_the_route_enters_every_room_and_touches_nothing(seed):
    found = laboratory(seed)
    for (x0, y0), (x1, y1) in itertools.pairwise(found.route):
        length, heading = np.hypot(x1 - x0, y1 - y0), np.arctan2(y1 - y0, x1 - x0)
        if length > 0.0:
            assert cast(found.walls, np.array([(x0, y0)]), np.array([heading]))[0] > length
    begin, along = found.walls[:, :2], found.walls[:, 2:] - found.walls[:, :2]
    squared = np.maximum((along**2).sum(axis=1), 1e-9)
    for point in drive(found.route)[::20, :2]:
        place = np.clip(((point - begin) * along).sum(axis=1) / squared, 0.0, 1.0)
        assert np.hypot(*(begin + place[:, None] * along - point).T).min() > 0.25


def test_laboratories_differ_in_their_rooms_and_are_half_a_kilometre_long():
    one, same, other = (laboratory(seed) for seed in (0, 0, 1))
    np.testing.assert_array_equal(one.walls, same.walls)
    assert one.walls.shape != other.walls.shape or not np.allclose(one.walls, other.walls)
    assert 400.0 < np.hypot(*np.diff(one.route, axis=0).T).sum() < 500.0
    assert one.walls[:, 0].min() < -CORRIDOR
