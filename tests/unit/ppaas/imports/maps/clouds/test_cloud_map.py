import numpy as np
import pytest

from ppaas.errors import InvalidInput, InvalidMap
from ppaas.imports.maps.clouds.cloud_map import map_of_cloud
from ppaas.imports.maps.clouds.point_cloud import PointCloud, ScanOrigin
from ppaas.imports.maps.common.imported_map import MapOptions
from ppaas.imports.report import ImportReport
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN
from ppaas.maps.octree import MIDDLE
from tests.support.world.clouds import hill_points, room_points


def import_points(points, origins=(), **options):
    report = ImportReport("cloud")
    cloud = PointCloud(points.astype(np.float32), np.zeros(3), origins)
    return map_of_cloud(cloud, MapOptions(**options), report), report


def cell_at(imported, x, y):
    return int(imported.grid.data[imported.grid.info.cell_of(x, y)])


def test_a_room_becomes_walls_a_door_and_free_floor():
    imported, report = import_points(room_points(), resolution=0.05)
    assert [cell_at(imported, *place) for place in ((1.0, 1.0), (3.0, 1.0), (2.0, 2.5))] == [FREE] * 3
    assert [cell_at(imported, *place) for place in ((2.02, 1.0), (0.02, 1.5), (3.0, 3.02))] == [OCCUPIED] * 3
    free = (imported.grid.data == FREE).sum() * 0.05**2
    assert free == pytest.approx(4.0 * 3.0, abs=0.6)
    assert "points above" in {entry.part for entry in report.entries}


def test_the_octomap_has_heights_above_the_floor():
    imported, _ = import_points(room_points(), resolution=0.1)
    low, high = imported.octomap.bounds()
    assert ((low[2] - MIDDLE) * 0.1, (high[2] - MIDDLE) * 0.1) == pytest.approx((0.0, 2.6), abs=0.11)
    voxels = imported.octomap.voxels()
    wall, above = voxels.info.to_voxels([(2.04, 1.0, 1.0), (1.0, 1.0, 0.5)])
    assert voxels.data[tuple(wall)] == 100 and voxels.data[tuple(above)] == 0


def test_heights_and_floor_may_be_given():
    table = np.stack(np.meshgrid(np.arange(1.0, 1.5, 0.02), np.arange(1.0, 1.5, 0.02), [1.2]), axis=-1).reshape(-1, 3)
    points = np.concatenate((room_points(), table))
    assert cell_at(import_points(points, resolution=0.05)[0], 1.2, 1.2) == OCCUPIED
    assert cell_at(import_points(points, resolution=0.05, heights=(0.15, 0.6))[0], 1.2, 1.2) == FREE
    higher, report = import_points(points, resolution=0.05, floor=1.2)
    assert cell_at(higher, 1.2, 1.2) == FREE
    assert any("as given" in entry.text for entry in report.entries)


def test_walls_alone_enclose_free_space():
    imported, report = import_points(room_points(floor=False, ceiling=False), resolution=0.1)
    assert cell_at(imported, 1.0, 1.0) == cell_at(imported, 3.0, 1.0) == FREE
    assert imported.grid.data[0, 0] == UNKNOWN
    assert any("the floor was not seen" in entry.text for entry in report.entries)


def test_a_given_place_frees_what_walls_around_it_enclose():
    rooms = np.concatenate((room_points(), room_points() + np.array((10.0, 0.0, 0.0))))
    imported, _ = import_points(rooms, resolution=0.1, start=(1.0, 1.0))
    assert cell_at(imported, 3.0, 1.0) == FREE
    assert cell_at(imported, 11.0, 1.0) == UNKNOWN
    for place, reason in (((7.0, 1.0), "not within walls"), ((2.02, 1.0), "in an obstacle"), ((99.0, 0.0), "outside")):
        with pytest.raises(InvalidInput, match=reason):
            import_points(rooms, resolution=0.1, start=place)


def test_rays_from_the_sensor_free_space_whose_floor_was_not_seen():
    points = room_points(floor=False, ceiling=False)
    strip = np.stack(np.meshgrid(np.arange(0.5, 1.0, 0.04), np.arange(0.5, 1.0, 0.04), [0.4]), axis=-1).reshape(-1, 3)
    points = np.concatenate((points, strip))
    origin = ScanOrigin((1.0, 1.0, 1.0), 0, len(points))
    blind, _ = import_points(points, resolution=0.05)
    seen, _ = import_points(points, (origin,), resolution=0.05)
    assert cell_at(blind, 1.5, 1.5) == UNKNOWN
    assert cell_at(seen, 1.5, 1.5) == FREE
    assert cell_at(seen, 2.02, 1.0) == OCCUPIED


def test_the_ground_of_a_slope_is_free_and_the_wall_on_it_is_not():
    imported, report = import_points(hill_points(), resolution=0.4)
    assert any(entry.text.startswith("terrain") for entry in report.entries)
    assert [cell_at(imported, *place) for place in ((3.0, 3.0), (25.0, 10.0), (7.0, 7.0))] == [FREE] * 3
    assert cell_at(imported, 15.0, 5.0) == OCCUPIED


@pytest.mark.parametrize(("spacing", "resolution"), [(0.02, 0.05), (0.1, 0.2), (0.5, 1.0)])
def test_the_resolution_suits_the_density_of_the_points(spacing, resolution):
    side = np.arange(0.0, 60 * spacing, spacing)
    floor = np.stack(np.meshgrid(side, side, [0.0]), axis=-1).reshape(-1, 3)
    imported, report = import_points(floor)
    assert imported.grid.info.resolution == resolution
    assert (imported.grid.data == FREE).mean() > 0.7
    assert any(entry.part == "resolution" for entry in report.entries)


def test_a_map_that_would_be_too_large_is_refused():
    with pytest.raises(InvalidMap, match="--resolution"):
        import_points(np.array([[0.0, 0.0, 0.0], [1e6, 1e6, 0.0]]))
    with pytest.raises(InvalidInput, match="--heights"):
        import_points(room_points(), heights=(1.0, 0.5))
