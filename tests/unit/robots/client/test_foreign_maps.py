import sys
from pathlib import Path

import numpy as np
import pye57
import pytest

from ppaas.errors import InvalidInput, InvalidMap
from ppaas.imports.maps.common.imported_map import MapOptions
from ppaas.maps.exports.point_files import pcd_file
from robots.client.foreign_maps import import_foreign_map
from tests.support.world.clouds import room_points


@pytest.fixture(scope="module")
def scans(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """Return the room in an E57 file, seen from one place in it."""
    path = Path(tmp_path_factory.mktemp("e57")) / "scans.e57"
    place = np.array((1.0, 1.0, 1.4))
    local = room_points() - place
    with pye57.E57(str(path), mode="w") as file:
        columns = {f"cartesian{axis}": local[:, number].copy() for number, axis in enumerate("XYZ")}
        file.write_scan_raw(columns, translation=place, rotation=np.array([1.0, 0.0, 0.0, 0.0]))
    return path.read_bytes()


def test_an_e57_is_the_same_map_as_its_points(scans: bytes) -> None:
    imported, report = import_foreign_map(scans, "room.e57", MapOptions(resolution=0.05))
    expected, _ = import_foreign_map(pcd_file(room_points().astype(np.float32)), "a.pcd", MapOptions(resolution=0.05))
    same = (imported.grid.data == expected.grid.data).mean()
    assert same > 0.98, "rays free some cells more"
    assert any("through which rays passed" in entry.text for entry in report.entries)


def test_a_damaged_file_is_refused_in_one_line(scans: bytes) -> None:
    for content in (scans[:200], scans[:1500], b"ASTM-E57" + bytes(100)):
        with pytest.raises(InvalidMap, match="the E57 cannot be read") as refused:
            import_foreign_map(content, "a.e57")
        assert "\n" not in str(refused.value) and len(str(refused.value)) < 200


def test_a_missing_library_is_named_with_its_extra(monkeypatch: pytest.MonkeyPatch, scans: bytes) -> None:
    monkeypatch.setitem(sys.modules, "pye57", None)
    with pytest.raises(InvalidInput, match=r"pye57: .*\.\[clouds\]"):
        import_foreign_map(scans, "a.e57")
