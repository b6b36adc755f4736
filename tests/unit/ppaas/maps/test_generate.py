"""Generated offices and warehouses."""

import numpy as np
import pytest
from scipy import ndimage

from ppaas.errors import InvalidParameter
from ppaas.maps.free_space import distance_to_occupied, reachable
from ppaas.maps.generate import office, warehouse

MAPS = [
    *[(make, seed, {}) for make in (office, warehouse) for seed in range(8)],
    *[(office, seed, {"width": 40.0, "height": 33.0}) for seed in range(3)],
    *[(office, seed, {"width": 9.0, "height": 10.0, "resolution": 0.1}) for seed in range(3)],
    *[(warehouse, seed, {"width": 60.0, "height": 40.0, "resolution": 0.1}) for seed in range(3)],
    *[(warehouse, seed, {"width": 15.0, "height": 8.0, "resolution": 0.07}) for seed in range(3)],
]


@pytest.mark.parametrize(("make", "seed", "size"), MAPS)
def test_robot_of_30_cm_radius_reaches_all_free_cells(make, seed, size):
    free = distance_to_occupied(make(seed, **size)) > 0.3
    row, column = np.argwhere(free)[0].tolist()
    assert np.array_equal(reachable(free, row, column), free)


@pytest.mark.parametrize(("make", "seed", "size"), MAPS)
def test_border_is_occupied_and_no_cell_is_unknown(make, seed, size):
    cells = make(seed, **size).data
    assert (cells[[0, -1]] == 100).all()
    assert (cells[:, [0, -1]] == 100).all()
    assert set(np.unique(cells).tolist()) == {0, 100}


@pytest.mark.parametrize("make", [office, warehouse])
def test_map_depends_on_the_seed(make):
    assert np.array_equal(make(5).data, make(5).data)
    assert not np.array_equal(make(5).data, make(6).data)


@pytest.mark.parametrize("make", [office, warehouse])
def test_size_and_resolution_are_as_requested(make):
    info = make(width=21.0, height=17.0, resolution=0.1).info
    assert (info.width, info.height, info.resolution) == (210, 170, 0.1)


def test_the_default_warehouse_measures_30_by_20_metres():
    assert warehouse().data.shape == (400, 600)


def test_an_office_has_rooms_behind_doors():
    # A robot wider than the widest door cannot enter the rooms: they are not connected to the corridor.
    assert ndimage.label(distance_to_occupied(office(width=24.0)) > 0.75)[1] > 5


def test_warehouse_aisles_are_wide():
    # With 2.5 m between the racks, a robot of 0.8 m radius can still pass a pallet in an aisle.
    aisles = distance_to_occupied(warehouse()) > 0.8
    row, column = np.argwhere(aisles)[0].tolist()
    assert reachable(aisles, row, column).sum() > 0.95 * aisles.sum()


@pytest.mark.parametrize("make", [office, warehouse])
@pytest.mark.parametrize(
    "size",
    [{"width": 3.0}, {"height": 3.0}, {"width": float("nan")}, {"resolution": 0.0}, {"resolution": 0.5}],
)
def test_a_building_too_small_or_too_coarse_is_refused(make, size):
    with pytest.raises(InvalidParameter, match=next(iter(size))):
        make(**size)
