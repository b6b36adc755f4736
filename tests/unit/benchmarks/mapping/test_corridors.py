import itertools

import numpy as np

from benchmarks.mapping.simulated_drive import cast
from benchmarks.mapping.worlds import HALF, OPEN, RECESS, corridor_route, corridors


def test_the_route_of_two_kilometres_stays_inside_the_corridors():
    walls, route = corridors(0), corridor_route()
    for (x0, y0), (x1, y1) in itertools.pairwise(route):
        length, heading = np.hypot(x1 - x0, y1 - y0), np.arctan2(y1 - y0, x1 - x0)
        assert cast(walls, np.array([(x0, y0)]), np.array([heading]))[0] > length
    assert 1800.0 < np.hypot(*np.diff(route, axis=0).T).sum() < 2200.0


def test_equal_corridors_look_alike_at_every_door_and_open_doors_are_deep():
    angles = np.linspace(-2.0, 2.0, 50)
    one, two = (cast(corridors(0, 0.0), np.full((50, 2), (x, 0.0)), angles).clip(max=4.0) for x in (31.8, 43.8))
    np.testing.assert_allclose(one, two, atol=1e-9)
    lowest = [corridors(0, share)[:, [1, 3]].min() for share in (0.0, 0.5)]
    np.testing.assert_allclose(lowest, [-HALF - RECESS, -HALF - OPEN])
