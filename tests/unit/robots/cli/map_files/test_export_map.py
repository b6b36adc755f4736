"""``ppaas map export``: of maps of a cloud, and of files."""

from pathlib import Path

import numpy as np
import pytest
import rasterio
from rasterio.warp import transform

from ppaas.imports.maps.clouds.pcd import read_pcd
from ppaas.imports.maps.clouds.ply import read_ply
from ppaas.imports.report import ImportReport
from ppaas.maps.exports.point_files import pcd_file
from tests.support.cloud.command_line import CommandLine
from tests.support.sources import ROOT
from tests.support.world.clouds import room_points

OFFICE = str(ROOT / "docs" / "examples" / "office.yaml")


async def test_a_published_map_is_exported_as_cloud_and_raster(ppaas: CommandLine, tmp_path: Path) -> None:
    room = tmp_path / "room.pcd"
    room.write_bytes(pcd_file(room_points().astype(np.float32)))
    await ppaas("map", "import", str(room), "--anchor", "48.1,11.5")
    for name in ("out.pcd", "out.ply", "out.tif"):
        written = await ppaas("map", "export", "room", "--out", str(tmp_path / name))
        assert (written.status, written.out) == (0, f"{tmp_path / name}\n"), written.err
    cloud = read_pcd((tmp_path / "out.pcd").read_bytes(), ImportReport("a")).points
    assert cloud[:, 2].max() == pytest.approx(2.5, abs=0.1), "the octomap has its ceiling"
    assert len(read_ply((tmp_path / "out.ply").read_bytes(), ImportReport("a")).points) == len(cloud)
    with rasterio.open(tmp_path / "out.tif") as file:
        longitude, latitude = transform(file.crs, "EPSG:4326", [0.0], [0.0])
        assert (latitude[0], longitude[0]) == pytest.approx((48.1, 11.5))


async def test_a_map_in_files_is_exported_without_a_cloud(ppaas: CommandLine, tmp_path: Path) -> None:
    written = await ppaas("map", "export", OFFICE, "--out", str(tmp_path / "office.pcd"), user=None)
    assert written.status == 0, written.err
    assert not read_pcd((tmp_path / "office.pcd").read_bytes(), ImportReport("a")).points[:, 2].any()


@pytest.mark.parametrize(
    ("source", "out", "reason"),
    [
        (OFFICE, "office.stl", "known: .pcd"),
        (OFFICE, "nowhere/office.pcd", "no folder"),
        ("missing.yaml", "a.pcd", "cannot read the map"),
        ("missing.bt", "a.tif", "cannot read the map"),
    ],
)
async def test_what_cannot_work_is_refused(
    ppaas: CommandLine, tmp_path: Path, source: str, out: str, reason: str
) -> None:
    refused = await ppaas("map", "export", source, "--out", str(tmp_path / out), user=None)
    assert refused.status == 1 and reason in refused.err
