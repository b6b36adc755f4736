import math

import numpy as np
import pytest
import rasterio

from ppaas.geometry import Pose2D
from ppaas.imports.maps.gis.raster import import_raster
from ppaas.maps.exports.geotiff import geotiff_file
from ppaas.maps.georeference import GeoAnchor
from ppaas.maps.grid import GridInfo, GridMap

CELLS = np.zeros((30, 50), np.int8)
CELLS[4:6, 40:44], CELLS[-1], CELLS[20, 10] = 100, -1, 100
GRID = GridMap(CELLS, GridInfo(0.2, 50, 30, Pose2D(-3.0, 4.0, 0.3)))


def test_cells_are_where_the_georeference_has_them():
    anchor = GeoAnchor(48.1, 11.5, 0.4)
    imported, _ = import_raster(geotiff_file(GRID, anchor), "a.tif")
    assert np.array_equal(imported.grid.data, CELLS)
    assert imported.grid.info.resolution == pytest.approx(0.2, abs=1e-6)
    for x, y in ((0.0, 0.0), (2.0, 6.0)):
        there = imported.anchor.to_map(*anchor.to_earth(x, y))
        assert np.abs(imported.grid.info.to_cells([there]) - GRID.info.to_cells([(x, y)])).max() <= 1
    assert math.isclose(imported.anchor.yaw, 0.4 + 0.3, abs_tol=1e-5)


def test_a_map_without_georeference_has_its_own_metres():
    with rasterio.MemoryFile(geotiff_file(GRID, None)) as memory, memory.open() as file:
        assert file.crs is None
        assert file.nodata == 255
        assert rasterio.transform.xy(file.transform, 30, 0, offset="ul") == pytest.approx((-3.0, 4.0))
        assert np.array_equal(file.read(1)[::-1], np.where(CELLS < 0, 255, CELLS.astype(np.int16)))
