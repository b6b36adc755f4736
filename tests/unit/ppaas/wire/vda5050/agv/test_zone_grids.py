"""Zones as masks."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.maps.grid import GridMap
from ppaas.wire.vda5050.agv.zone_grids import (
    BARRED,
    MAX_CELLS,
    SPEED_STEP,
    keepout_mask,
    marked_point,
    speed_mask,
)
from ppaas.wire.vda5050.fields import Point
from ppaas.wire.vda5050.zones import Zone, Zones, ZoneType


def zones(*polygons: tuple[ZoneType, list[tuple[float, float]], float | None]) -> Zones:
    made = [
        Zone(zone_id=str(index), zone_type=kind, vertices=[Point(x=x, y=y) for x, y in corners], maximum_speed=speed)
        for index, (kind, corners, speed) in enumerate(polygons)
    ]
    return Zones(map_id="hall", zone_set_id="z", zones=made)


def square(x: float, y: float, size: float) -> list[tuple[float, float]]:
    return [(x, y), (x + size, y), (x + size, y + size), (x, y + size)]


def at(mask: GridMap, x: float, y: float) -> int:
    cell = mask.info.cell_of(x, y)
    return 0 if cell is None else int(mask.data[cell])


def test_blocked_zones_bar_the_cells_that_they_touch() -> None:
    mask = keepout_mask(zones(("BLOCKED", square(1.0, 2.0, 1.0), None), ("SPEED_LIMIT", square(5.0, 5.0, 1.0), 0.2)))
    assert at(mask, 1.5, 2.5) == at(mask, 1.001, 2.001) == at(mask, 1.999, 2.999) == BARRED
    assert at(mask, 0.5, 2.5) == at(mask, 2.5, 2.5) == at(mask, 5.5, 5.5) == 0


def test_concave_zones_leave_their_bay_free() -> None:
    bay = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (3.0, 4.0), (3.0, 1.0), (1.0, 1.0), (1.0, 4.0), (0.0, 4.0)]
    mask = keepout_mask(zones(("BLOCKED", bay, None)))
    assert (at(mask, 0.5, 3.0), at(mask, 2.0, 3.0), at(mask, 3.5, 3.0), at(mask, 2.0, 0.5)) == (
        BARRED,
        0,
        BARRED,
        BARRED,
    )


def test_the_lowest_speed_counts_and_zones_grow_by_the_robot() -> None:
    slow, fast = ("SPEED_LIMIT", square(0.0, 0.0, 2.0), 0.1), ("SPEED_LIMIT", square(1.0, 0.0, 2.0), 0.35)
    for order in ((slow, fast), (fast, slow)):
        mask = speed_mask(zones(*order), radius=0.2)  # type: ignore[arg-type]
        assert at(mask, 1.5, 1.0) * SPEED_STEP == pytest.approx(0.1)
        assert at(mask, 2.8, 1.0) * SPEED_STEP == pytest.approx(0.34)
        assert at(mask, -0.15, 1.0) > 0
        assert at(mask, -0.4, 1.0) == 0


def test_without_zones_a_mask_has_no_effect() -> None:
    assert marked_point(keepout_mask(zones())) is None
    assert marked_point(speed_mask(zones(), 0.2)) is None


def test_zones_far_from_each_other_have_larger_cells() -> None:
    mask = keepout_mask(zones(("BLOCKED", square(-9000, -9000, 1.0), None), ("BLOCKED", square(9000, 9000, 1.0), None)))
    assert mask.data.size <= MAX_CELLS * 1.01
    assert at(mask, -8999.5, -8999.5) == at(mask, 9000.5, 9000.5) == BARRED


coordinates = st.floats(-20, 20)


@given(st.lists(st.tuples(coordinates, coordinates), min_size=3, max_size=8))
def test_every_point_of_an_edge_is_barred(corners: list[tuple[float, float]]) -> None:
    mask = keepout_mask(zones(("BLOCKED", corners, None)))
    for (x0, y0), (x1, y1) in zip(corners, corners[1:] + corners[:1], strict=True):
        for part in np.linspace(0.0, 1.0, 7):
            assert at(mask, x0 + part * (x1 - x0), y0 + part * (y1 - y0)) == BARRED
    point = marked_point(mask)
    assert point is not None and at(mask, *point) == BARRED and math.isfinite(sum(point))
