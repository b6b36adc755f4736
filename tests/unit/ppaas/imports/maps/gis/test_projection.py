import math

import numpy as np
import pytest

from ppaas.errors import InvalidMap
from ppaas.imports.maps.gis.projection import local_frame, parse_projection


def test_utm_is_scaled_and_turned():
    # Of PROJ 9.5.1: the scale is 1.00004896 there, and the meridian 1.91° to the left of the grid's north.
    anchor, metres = local_frame(parse_projection("EPSG:25832"), 691_000.0, 5_334_000.0)
    assert (anchor.latitude, anchor.longitude, anchor.yaw) == pytest.approx((48.1288, 11.5665, 0.0), abs=2e-3)
    across = metres @ (1.0, 0.0)
    assert math.hypot(*across) == pytest.approx(1.0 / 1.00004896, abs=1e-6)
    assert math.degrees(math.atan2(across[1], across[0])) == pytest.approx(-1.91, abs=0.02)


def test_degrees_and_feet_become_metres():
    _, of_degrees = local_frame(parse_projection("EPSG:4326"), 11.5, 48.1)
    assert np.diag(of_degrees) == pytest.approx((74_480.0, 111_200.0), abs=40.0)
    _, of_feet = local_frame(parse_projection("EPSG:2263"), 980_000.0, 200_000.0)
    assert math.sqrt(np.linalg.det(of_feet)) == pytest.approx(0.3048, abs=1e-4)


def test_unknown_systems_and_places_off_the_earth_are_refused():
    with pytest.raises(InvalidMap, match="PROJ does not know"):
        parse_projection("EPSG:999999")
    with pytest.raises(InvalidMap, match="not on the Earth"):
        local_frame(parse_projection("EPSG:4326"), 11.5, 480.0)
