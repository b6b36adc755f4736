import numpy as np
import pytest

from ppaas.imports.maps.common.imported_map import MapOptions
from ppaas.imports.maps.gis.pixel_values import MEANINGS, cells_of_raster
from ppaas.imports.report import ImportReport


def cells(pixels, valid=None, size=1.0, **options):
    bands = np.asarray(pixels)
    bands = bands if bands.ndim == 3 else bands[np.newaxis]
    report = ImportReport("a.tif")
    valid = np.ones(bands.shape[1:], np.bool_) if valid is None else np.asarray(valid)
    found = cells_of_raster(bands, valid, size, MapOptions(**options), report)
    return found.tolist(), report


def row(*values, dtype):
    return np.array([values], dtype)


@pytest.mark.parametrize(
    ("values", "expected", "word"),
    [
        (row(0, 205, 254, 255, dtype=np.uint8), [100, -1, 0, 0], "greys"),
        (np.moveaxis(np.array([[[0, 0, 0], [255, 255, 255]]], np.uint8), -1, 0), [100, 0], "greys"),
        (row(0, 19, 50, 65, 100, dtype=np.uint8), [0, 0, -1, 100, 100], "occupancies"),
        (row(-1, 0, 100, dtype=np.int16), [-1, 0, 100], "occupancies"),
        (row(0.0, 0.5, 0.9, dtype=np.float32), [0, -1, 100], "occupancies"),
        (row(0, 1, 1, dtype=np.uint8), [0, 100, 100], "mask"),
        (row(4.0, 4.1, 4.2, 5.0, dtype=np.float32), [0, 0, 100, 100], "heights"),
        (row(400, 400, 401, dtype=np.int16), [0, 100, 100], "heights"),
    ],
)
def test_the_meaning_is_found_by_type_and_range(values, expected, word):
    found, report = cells(values)
    assert found == [expected]
    assert word in report.entries[0].text


def test_the_meaning_may_be_given():
    values = row(0, 1, 100, dtype=np.uint8)
    assert cells(values, values="mask")[0] == [[0, 100, 100]]
    assert cells(values, values="greys")[0] == [[100, 100, -1]]
    assert {cells(values, values=meaning)[1].entries[0].part for meaning in MEANINGS} == {"values"}


def test_pixels_without_data_are_unknown():
    found, report = cells(row(0, 1, 1, dtype=np.uint8), valid=[[True, True, False]])
    assert found == [[0, 100, -1]]
    assert report.entries[-1].text == "1 pixels are unknown"
    assert cells(row(3.0, 0.0, 9.0, dtype=np.float64), valid=[[False, True, False]])[0] == [[-1, 0, -1]]


@pytest.mark.parametrize(("slope", "size", "blocked"), [(10.0, 1.0, True), (10.0, 2.0, False), (20.0, 1.0, False)])
def test_steep_ground_is_occupied(slope, size, blocked):
    heights = np.tile(np.arange(5.0) * 0.25 + 3.0, (4, 1))  # 14° if pixels are 1 m large
    found, _ = cells(heights, size=size, max_slope=slope)
    assert (np.array(found) == (100 if blocked else 0)).all()
