import io
import math

import numpy as np
import pytest
import rasterio
from PIL import Image

from ppaas.errors import InvalidInput, InvalidMap
from ppaas.geometry import Pose2D
from ppaas.imports.maps.common.imported_map import MapOptions
from ppaas.imports.maps.gis.projection import local_frame, parse_projection
from ppaas.imports.maps.gis.raster import import_raster
from tests.support.world.rasters import CORNER, UTM, raster

YARD = np.zeros((40, 60), np.uint8)
YARD[:, [0, -1]] = YARD[[0, -1]] = 1
YARD[5:8, 50] = 1


def place_of(x, y):
    """Return latitude and longitude of a place in UTM."""
    anchor, _ = local_frame(parse_projection(UTM), x, y)
    return anchor.latitude, anchor.longitude


@pytest.mark.parametrize("compress", ["none", "lzw", "deflate"])
def test_pixels_are_where_they_are_on_the_earth(compress):
    imported, report = import_raster(raster(YARD, compress=compress), "yard.tif")
    grid, anchor = imported.grid, imported.anchor
    assert grid.info.resolution == pytest.approx(0.5 / 1.00004896, abs=1e-5)
    assert grid.info.origin == Pose2D(0.0, 0.0, 0.0)
    pixel = CORNER[0] + 50.5 * 0.5, CORNER[1] - 6.5 * 0.5
    assert grid.data[grid.info.cell_of(*anchor.to_map(*place_of(*pixel)))] == 100
    assert grid.data[grid.info.cell_of(*anchor.to_map(*place_of(pixel[0] - 2.0, pixel[1])))] == 0
    assert any(entry.part == "georeference" for entry in report.entries)


def test_a_turned_raster_keeps_its_pixels():
    c, s = 0.5 * math.cos(math.radians(30.0)), 0.5 * math.sin(math.radians(30.0))
    affine = rasterio.Affine(c, s, CORNER[0], s, -c, CORNER[1])
    imported, _ = import_raster(raster(YARD, affine=affine), "yard.tif")
    assert np.array_equal(imported.grid.data > 0, YARD[::-1] > 0)
    assert math.degrees(imported.anchor.yaw) == pytest.approx(30.0 - 1.91, abs=0.05)
    x, y = c * 50.5 + s * 6.5 + CORNER[0], s * 50.5 - c * 6.5 + CORNER[1]
    assert imported.grid.data[imported.grid.info.cell_of(*imported.anchor.to_map(*place_of(x, y)))] == 100


def test_pixels_in_degrees_become_square():
    affine = rasterio.Affine(5e-6, 0.0, 11.5, 0.0, -5e-6, 48.1)
    imported, report = import_raster(raster(YARD, affine=affine, crs="EPSG:4326"), "yard.tif")
    assert imported.grid.info.resolution == pytest.approx(0.3724, abs=1e-3)
    assert (imported.grid.info.width, imported.grid.info.height) == (60, 60)
    assert any(entry.part == "pixels" for entry in report.entries)


def test_a_coarser_resolution_keeps_obstacles():
    imported, _ = import_raster(raster(YARD), "yard.tif", MapOptions(resolution=2.0))
    assert (imported.grid.info.width, imported.grid.info.height) == (15, 10)
    assert imported.grid.data[10 - 1 - 1, 12] == 100


def test_an_ascii_grid_takes_the_projection_beside_it():
    heights = np.full((20, 30), 412.5, np.float32)
    heights[:, 15:] += 2.0
    content = raster(heights, driver="AAIGrid")
    assert content.lower().startswith(b"ncols")
    wkt = rasterio.crs.CRS.from_string(UTM).to_wkt(version="WKT1_ESRI").encode()
    imported, _ = import_raster(content, "dem.asc", MapOptions(projection=wkt))
    assert imported.anchor is not None
    assert (imported.grid.data[10] == 100).sum() == 2
    alone, report = import_raster(content, "dem.asc")
    assert alone.anchor is None and alone.grid.info.origin == Pose2D(0.0, 0.0, 0.0)
    assert any("taken for metres" in entry.text for entry in report.entries)


def picture():
    file = io.BytesIO()
    Image.fromarray(np.where(YARD > 0, 0, 255).astype(np.uint8)).save(file, "PNG")
    return file.getvalue()


def test_a_picture_has_a_world_file():
    world = b"0,1\r\n0\r\n0\r\n-0.1\r\n3.05\r\n7.95\r\n"
    imported, _ = import_raster(picture(), "yard.png", MapOptions(world=world))
    assert imported.grid.info.origin == Pose2D(pytest.approx(3.0), pytest.approx(4.0), 0.0)
    assert imported.grid.info.resolution == 0.1
    for world in (b"1 2 3", b"a b c d e f"):
        with pytest.raises(InvalidMap, match="six numbers"):
            import_raster(picture(), "yard.png", MapOptions(world=world))


def test_a_picture_alone_needs_a_resolution():
    with pytest.raises(InvalidInput, match="from-plan"):
        import_raster(picture(), "yard.png")
    imported, _ = import_raster(picture(), "yard.png", MapOptions(resolution=0.2))
    assert imported.grid.info.resolution == 0.2


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"II*\0" + bytes(100), "cannot be read"),
        (raster(YARD)[:20], "cannot be read"),
        (b"ncols 3\nnrows", "cannot be read"),
        (raster(np.ones((3, 4), np.uint8)), "no cell of the map would be free"),
        (raster(YARD, affine=rasterio.Affine(0.5, 0.4, CORNER[0], 0.0, -0.5, CORNER[1])), "no rectangles"),
        (raster(YARD, size=1e-9), "m large"),
        (b"ncols 999999\nnrows 999999\nxllcorner 0\nyllcorner 0\ncellsize 1\n" + b"0 " * 100, "cells"),
    ],
)
def test_what_cannot_be_a_map_is_refused(content, reason):
    with pytest.raises(InvalidMap, match=reason):
        import_raster(content, "yard.tif")
