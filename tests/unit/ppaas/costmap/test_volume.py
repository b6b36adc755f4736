import math

import pytest

from ppaas.costmap.volume import Box, Cylinder
from ppaas.errors import InvalidParameter


def test_swept_radius_reaches_the_corners_of_a_box():
    assert Box(0.6, 0.8, 1.0).swept_radius == pytest.approx(0.5)
    assert Cylinder(0.2, 1.0).swept_radius == 0.2


@pytest.mark.parametrize("size", [0.0, -1.0, math.nan, math.inf])
def test_invalid_sizes_are_refused(size):
    for kind, sizes in ((Cylinder, (0.2, size)), (Box, (size, 1, 1)), (Box, (1, size, 1)), (Box, (1, 1, size))):
        with pytest.raises(InvalidParameter, match="metres"):
            kind(*sizes)


@pytest.mark.parametrize("radius", [-0.1, math.nan, math.inf])
def test_radius_may_be_zero_but_not_negative(radius):
    assert Cylinder(0.0, 1.0).radius == 0.0
    with pytest.raises(InvalidParameter, match="radius"):
        Cylinder(radius, 1.0)
