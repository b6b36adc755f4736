"""Pictures of the floors of a building."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ppaas.errors import InvalidInput
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.zones.reading import geojson_of
from ppaas.zones.shapes import LineString
from ppaas.zones.zone import Door, Zone, ZoneSet
from robots.pictures.floors import FloorPicture, write_floors


def floor(name: str, *zones: Zone) -> FloorPicture:
    grid = GridMap(np.zeros((400, 500), np.int8), GridInfo(0.05, 500, 400))
    return FloorPicture(name, grid, geojson_of(ZoneSet(list(zones))))


def test_floors_are_beside_each_other_with_their_doors(tmp_path: Path) -> None:
    door = Zone(LineString([[5.0, 10.0], [15.0, 10.0]]), Door(name="gate"))
    write_floors(tmp_path / "x.png", [floor("L1"), floor("L2", door)])
    with Image.open(tmp_path / "x.png") as drawn:
        pixels = np.asarray(drawn.convert("RGB"))
    assert pixels.shape == (464, 1072, 3)
    columns = np.flatnonzero((pixels == (190, 80, 30)).all(axis=2).any(axis=0))
    assert columns.min() >= 24 + 500 + 24 and len(columns) > 190


def test_a_file_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    for path in (tmp_path / "x.jpg", tmp_path / "none" / "x.png"):
        with pytest.raises(InvalidInput):
            write_floors(path, [floor("L1")])
