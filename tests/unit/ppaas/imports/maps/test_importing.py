import io
import json
import sys

import laspy
import numpy as np
import pytest

from ppaas.errors import InvalidInput, InvalidMap
from ppaas.imports.maps.common.imported_map import MapOptions, files_of
from ppaas.imports.maps.importing import import_map
from ppaas.imports.report import ImportOutcome
from ppaas.maps.exports.point_files import pcd_file, ply_file, xyz_file
from ppaas.maps.formats.map_files import load_map
from ppaas.maps.georeference import GeoAnchor, anchor_of
from ppaas.maps.octomap import parse_octomap
from ppaas.zones.reading import zones_of
from tests.support.world.clouds import room_points
from tests.support.world.rasters import raster

ROOM = room_points().astype(np.float32)
VALETUDO = json.dumps(
    {
        "size": {"x": 500, "y": 500},
        "pixelSize": 5,
        "layers": [{"type": "floor", "compressedPixels": [10, 20, 30]}],
        "entities": [{"type": "no_go_area", "points": [50, 100, 60, 100, 60, 110]}],
    }
).encode()
LAWN = json.dumps(
    {"areas": [{"properties": {"type": "mow"}, "outline": [{"x": 0, "y": 0}, {"x": 5, "y": 0}, {"x": 0, "y": 5}]}]}
).encode()
VALETUDO_RE = json.dumps(
    {"image": {"position": {"left": 9, "top": 9}, "dimensions": {"width": 2, "height": 2}, "pixels": {"floor": [0, 3]}}}
).encode()


def survey():
    file = laspy.LasData(laspy.LasHeader(point_format=6, version="1.4"))
    file.x, file.y, file.z = ROOM.T
    written = io.BytesIO()
    file.write(written, do_compress=True)
    return written.getvalue()


FILES = {
    "home.json": VALETUDO, "old.json": VALETUDO_RE, "lawn.json": LAWN, "room.pcd": pcd_file(ROOM),
    "room.PLY": ply_file(ROOM),
    "room.xyz": xyz_file(ROOM), "room.asc": xyz_file(ROOM), "room.laz": survey(), "unnamed": pcd_file(ROOM),
    "yard.tif": raster(np.eye(9, dtype=np.uint8)), "yard.asc": raster(np.eye(9, dtype=np.uint8), driver="AAIGrid"),
}  # fmt: skip


@pytest.mark.parametrize("name", FILES)
def test_a_file_of_any_format_becomes_files_of_a_map(name):
    imported, report = import_map(FILES[name], name, MapOptions(anchor=GeoAnchor(48.0, 11.0)))
    files = files_of(imported, "map.pgm")
    grid = load_map(files.yaml, files.image)
    assert np.array_equal(grid.data, imported.grid.data)
    assert (grid.data == 0).any()
    assert anchor_of(files.yaml) == GeoAnchor(48.0, 11.0)
    assert (files.octomap is not None) == name.startswith(("room", "unnamed"))
    if files.octomap is not None:
        assert parse_octomap(files.octomap).occupied.any()
    assert (files.zones is not None) == (name == "home.json")
    if files.zones is not None:
        assert zones_of(files.zones) == imported.zones
    assert report.source == name and list(report.of(ImportOutcome.TRANSLATED))


def test_a_survey_is_in_metres_of_the_earth():
    wkt = __import__("rasterio").crs.CRS.from_epsg(25832).to_wkt()
    file = laspy.LasData(laspy.LasHeader(point_format=6, version="1.4"))
    file.header.vlrs.append(laspy.vlrs.known.WktCoordinateSystemVlr(wkt))
    file.header.offsets = [691_000.0, 5_334_000.0, 0.0]
    file.x, file.y, file.z = (ROOM + np.array((691_050.0, 5_334_050.0, 0.0))).T
    written = io.BytesIO()
    file.write(written)
    imported, report = import_map(written.getvalue(), "a.las", MapOptions(resolution=0.05))
    assert (imported.anchor.latitude, imported.anchor.longitude) == pytest.approx((48.128, 11.567), abs=0.01)
    assert imported.anchor.yaw == 0.0
    # The grid of the projection is turned by 1.9°, so the room is, too.
    width = imported.grid.info.width * 0.05
    assert 4.05 < width < 4.5
    assert any(entry.part == "georeference" for entry in report.entries)


def test_a_cloud_with_y_up_in_millimetres_is_the_same_map():
    turned = np.stack((ROOM[:, 0], ROOM[:, 2], -ROOM[:, 1]), axis=1) * np.float32(1000.0)
    options = MapOptions(up="y", unit=0.001, resolution=0.05)
    imported, report = import_map(pcd_file(turned), "a.pcd", options)
    expected, _ = import_map(FILES["room.pcd"], "a.pcd", MapOptions(resolution=0.05))
    assert imported.grid.info == expected.grid.info
    assert (imported.grid.data == expected.grid.data).mean() > 0.98, "points at the edges of cells are rounded"
    assert report.entries[1].text == "y of the file is up, and its unit 0.001 m"


def test_without_rasterio_a_survey_has_no_georeference(monkeypatch):
    monkeypatch.setitem(sys.modules, "rasterio", None)
    content = FILES["room.laz"]
    assert import_map(content, "a.laz")[0].anchor is None
    with pytest.raises(InvalidInput, match=r"\.\[gis\]"):
        import_map(FILES["yard.tif"], "yard.tif")


def test_a_missing_library_is_named_with_its_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "laspy", None)
    with pytest.raises(InvalidInput, match=r"laspy: .*\.\[clouds\]"):
        import_map(FILES["room.laz"], "room.laz")


@pytest.mark.parametrize(
    ("content", "name", "reason"),
    [
        (b"", "a.pcd", "empty"),
        (b"image: a.pgm", "a.yaml", "map publish"),
        (b"<svg/>", "a.svg", "from-plan"),
        (b"#ROSBAG V2.0", "map.bag", "as JSON"),
        (b"[1, 2]", "a.json", "neither a map of Valetudo"),
        (b"\x00\x01", "a.bin", "known: maps of Valetudo"),
        (b"\x89PNG\r\n\x1a\n", "a.png", "from-plan"),
    ],
)
def test_other_files_are_refused_with_what_to_do(content, name, reason):
    with pytest.raises((InvalidMap, InvalidInput), match=reason):
        import_map(content, name)


def test_the_real_map_of_a_vacuum_is_one_room_to_drive_in(data):
    from ppaas.maps.free_space import reachable

    imported, _ = import_map((data / "foreign" / "valetudo.json").read_bytes(), "valetudo.json")
    free = imported.grid.data == 0
    robot = imported.grid.info.cell_of(25.64, 25.40)
    assert reachable(free, *robot).sum() > 0.9 * free.sum()
