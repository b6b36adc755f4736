"""Commands of foreign-maps.md work, and its tables and numbers are those of the code."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from ppaas.imports.maps.clouds import cloud_map, ground
from ppaas.imports.maps.common.imported_map import MapOptions
from ppaas.imports.maps.drawings.plan_import import DRAWINGS
from ppaas.imports.maps.drawings.plan_picture import DARK
from ppaas.imports.maps.gis.pixel_values import MEANINGS
from ppaas.imports.maps.importing import CLOUDS
from ppaas.maps.exports.point_files import xyz_file
from ppaas.maps.georeference import anchor_of
from tests.support.cloud.cloud import RunningCloud
from tests.support.documents import blocks, run_shell, script, table, text_of
from tests.support.world.clouds import room_points
from tests.support.world.plans import svg_plan
from tests.support.world.rasters import raster

PAGE = "docs/foreign-maps.md"

CORNERS = [{"x": x, "y": y} for x, y in ((0, 0), (8, 0), (8, 6), (0, 6))]
POND = [{"x": x, "y": y} for x, y in ((3, 2), (4, 2), (4, 3))]
LAWN = {
    "areas": [
        {"id": "a", "properties": {"type": "mow", "name": "front"}, "outline": CORNERS},
        {"id": "b", "properties": {"type": "obstacle", "name": "pond"}, "outline": POND},
    ]
}


def test_the_endings_are_those_of_the_code() -> None:
    rows = table(PAGE, "format", "endings", "becomes", "extra")
    endings = {ending for _, cell, *_ in rows for ending in re.findall(r"`(\.\w+)`", cell)}
    assert {*CLOUDS, ".e57", ".tif", ".tiff", ".svg", ".dxf", ".pdf"} <= endings
    assert {ending for ending in endings if ending in DRAWINGS} >= {".png", ".jpg", ".bmp", ".svg", ".dxf", ".pdf"}


def test_the_meanings_of_pixels_are_those_of_the_code() -> None:
    assert [name for name, *_ in table(PAGE, "--values", "pixels", "found if")] == list(MEANINGS)


def test_the_numbers_are_those_of_the_code() -> None:
    text = re.sub(r"\s+", " ", text_of(PAGE))
    options = MapOptions()
    assert f"at least {ground.LEAST_SHARE:.0%}".replace("%", " %") in text
    assert f"above the floor, {options.heights[0]:g} to {options.heights[1]:g} m unless" in text
    assert f"From {cloud_map.RESOLUTIONS[0]:g} m on" in text and cloud_map.LEAST_PER_CELL == 3.0
    assert f"`--max-slope` ({options.max_slope:g}°)" in text
    assert f"`--dark` ({DARK} of 255)" in text


def test_the_georeference_of_the_example_is_valid() -> None:
    [example] = blocks(PAGE, "yaml")
    anchor = anchor_of(b"image: a.pgm\n" + example.encode())
    assert anchor is not None and anchor.latitude == 48.137154


@pytest.mark.journey
def test_the_shell_commands_work(cloud: RunningCloud, tmp_path: Path) -> None:
    (tmp_path / "scan.xyz").write_bytes(xyz_file(room_points().astype(np.float32)))
    (tmp_path / "yard.asc").write_bytes(
        raster(np.tile(np.arange(20.0, dtype=np.float32) + 5.0, (15, 1)), size=9.0, driver="AAIGrid")
    )
    (tmp_path / "lawn.json").write_text(json.dumps(LAWN))
    (tmp_path / "flat.svg").write_bytes(svg_plan())
    [login] = [line for line in script("README.md").splitlines() if line.startswith("export PPAAS_TOKEN")]
    printed = run_shell(f"{login}\n{script(PAGE)}", tmp_path, cloud)
    assert all(name in printed for name in ("scan", "yard", "lawn", "flat", "scan.pcd", "lawn.ply"))
    assert (tmp_path / "scan.pcd").read_bytes().startswith(b"# .PCD")
    assert {"scan.bt", "scan.pgm", "scan.yaml"} <= {file.name for file in (tmp_path / "copies").iterdir()}
    assert (tmp_path / "flat.png").is_file()
