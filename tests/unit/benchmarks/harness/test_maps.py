"""Maps of the benches."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.harness.maps import RESOLUTION, read_map
from ppaas.errors import InvalidMap
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN


def test_generated_maps_need_no_file() -> None:
    assert read_map("office").data.shape != read_map("warehouse").data.shape


def test_only_lethal_cells_next_to_others_become_walls(tmp_path: Path) -> None:
    pixels = np.full((4, 6), 254, np.uint8)
    pixels[0, 0], pixels[0, 1] = 50, 253
    path = tmp_path / "costmap.pgm"
    path.write_bytes(b"P5\n6 4\n255\n" + pixels.tobytes())
    grid = read_map(str(path))
    assert grid.info.resolution == RESOLUTION
    assert grid.data[-1, :2].tolist() == [FREE, FREE]
    assert grid.data[-1, 2] == grid.data[-2, 0] == grid.data[-2, 2] == OCCUPIED
    assert grid.data[-1, 3] == grid.data[0, 0] == UNKNOWN


@pytest.mark.parametrize("name", ["nowhere.yaml", "nowhere.pgm"])
def test_a_missing_map_is_refused(name: str) -> None:
    with pytest.raises(InvalidMap, match="cannot read the map"):
        read_map(name)
