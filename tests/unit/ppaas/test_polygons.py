"""Polygons in the plane."""

import numpy as np
import pytest

from ppaas.polygons import within_polygon


@pytest.mark.parametrize(("point", "inside"), [((1.0, 0.5), True), ((3.0, 0.5), False), ((1.0, 1.9), False)])
def test_a_polygon_may_have_a_notch(point: tuple[float, float], inside: bool) -> None:
    corners = np.array([(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (1.0, 1.0), (0.0, 2.0)])
    assert within_polygon(corners, np.array([point])).tolist() == [inside]


@pytest.mark.filterwarnings("error")
def test_an_edge_that_is_nearly_level_overflows_nothing() -> None:
    corners = np.array([(0.0, 0.0), (4e9, 5e-324), (4e9, 2.0), (0.0, 2.0)])
    assert within_polygon(corners, np.array([(1.0, 1.0), (1.0, 3.0)])).tolist() == [True, False]
