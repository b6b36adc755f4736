"""``ppaas map import`` and ``from-plan``: files, publications, reports and pictures."""

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ppaas.maps.exports.point_files import pcd_file
from ppaas.maps.georeference import GeoAnchor, anchor_of
from robots.cli.map_files.import_map import MAX_FILE
from robots.client.map_files import read_map_file
from tests.support.cloud.command_line import CommandLine
from tests.support.world.clouds import room_points
from tests.support.world.plans import svg_plan

HOME = {
    "size": {"x": 500, "y": 500},
    "pixelSize": 5,
    "layers": [
        {"type": "floor", "compressedPixels": [value for row in range(20, 60) for value in (10, row, 60)]},
        {"type": "wall", "compressedPixels": [value for row in (19, 60) for value in (10, row, 60)]},
    ],
    "entities": [{"type": "no_go_area", "points": [100, 200, 150, 200, 150, 250, 100, 250]}],
}


@pytest.fixture
def home(tmp_path: Path) -> Path:
    file = tmp_path / "home.json"
    file.write_text(json.dumps(HOME))
    return file


@pytest.fixture
def room(tmp_path: Path) -> Path:
    file = tmp_path / "room.pcd"
    file.write_bytes(pcd_file(room_points().astype(np.float32)))
    return file


async def test_a_map_is_published_with_its_zones(ppaas: CommandLine, home: Path) -> None:
    published = await ppaas("map", "import", str(home), "--message", "from the vacuum", "--json")
    assert published.status == 0, published.err
    answer = json.loads(published.out)
    assert (answer["id"], answer["message"], answer["width"], answer["height"]) == ("home", "from the vacuum", 68, 50)
    assert answer["parts"] == ["image", "yaml", "zones"]
    report = json.loads(published.err)
    assert report["source"] == "home.json"
    assert report["counts"] == {"taken": 0, "translated": 4, "no effect": 0, "refused": 0}


async def test_the_second_import_is_a_version_of_the_same_map(ppaas: CommandLine, home: Path) -> None:
    await ppaas("map", "import", str(home), "--id", "flat")
    again = await ppaas("map", "import", str(home), "--id", "flat", "--json")
    versions = await ppaas("map", "versions", "flat", "--json")
    assert again.status == 0 and len(json.loads(versions.out)) == 1


async def test_a_dry_run_needs_no_cloud_and_writes_nothing(ppaas: CommandLine, home: Path) -> None:
    tried = await ppaas("map", "import", str(home), "--dry-run", user=None)
    assert (tried.status, tried.out) == (0, "")
    assert "entities[0] no_go_area" in tried.err and tried.err.endswith("0 refused\n")
    assert sorted(home.parent.iterdir()) == [home]


async def test_files_and_a_picture_are_written(ppaas: CommandLine, room: Path, tmp_path: Path) -> None:
    out, picture = tmp_path / "maps", tmp_path / "room.png"
    written = await ppaas(
        "map", "import", str(room), "--out", str(out), "--picture", str(picture), "--anchor", "48.1,11.5,0.25",
        "--resolution", "0.05", "--heights", "0.1,1.2", user=None,
    )  # fmt: skip
    assert written.status == 0, written.err
    assert written.out.split() == [str(out / f"room{ending}") for ending in (".pgm", ".bt", ".yaml")]
    assert anchor_of((out / "room.yaml").read_bytes()) == GeoAnchor(48.1, 11.5, 0.25)
    assert read_map_file(out / "room.yaml").info.resolution == 0.05
    assert Image.open(picture).width > 900


async def test_a_robot_finds_its_way_through_the_door(ppaas: CommandLine, room: Path, tmp_path: Path) -> None:
    await ppaas("map", "import", str(room), "--out", str(tmp_path), user=None)
    ends = ("--start", "1", "1", "--goal", "3", "1", "--radius", "0.15")
    planned = await ppaas("plan", str(tmp_path / "room.yaml"), *ends, "--json", user=None)
    assert planned.status == 0, planned.err
    assert json.loads(planned.out)["length"] == pytest.approx(3.6, abs=0.4), "the wall between them is 2 m long"


async def test_a_plan_is_drawn_before_and_after(ppaas: CommandLine, tmp_path: Path) -> None:
    file, picture = tmp_path / "flat.svg", tmp_path / "both.png"
    file.write_bytes(svg_plan())
    scale = ("--scale-by", "100,100,900,100,8")
    made = await ppaas(
        "map", "from-plan", str(file), *scale, "--out", str(tmp_path), "--picture", str(picture), user=None
    )
    assert made.status == 0, made.err
    image = Image.open(picture)
    assert image.width > 2 * 1000
    planned = await ppaas("plan", str(tmp_path / "flat.yaml"), "--start", "2", "2.5", "--goal", "8", "2.5", user=None)
    assert planned.status == 0, planned.err
    published = await ppaas("map", "from-plan", str(file), *scale)
    assert published.status == 0 and "flat" in published.out


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (("import", "nothing.pcd"), "cannot read the map"),
        (("import", "home.json", "--picture", "a.jpg"), "PNG"),
        (("from-plan", "home.json"), "not a floor plan"),
        (("import", "home.json", "--anchor", "95,0"), "latitude"),
    ],
)
async def test_what_cannot_work_is_refused(
    ppaas: CommandLine, home: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...], reason: str
) -> None:
    monkeypatch.chdir(home.parent)
    refused = await ppaas("map", *arguments, user=None)
    assert refused.status == 1 and reason in refused.err


@pytest.mark.parametrize("option", [("--heights", "1"), ("--resolution", "0"), ("--anchor", "1"), ("--start", "nan,0")])
async def test_numbers_are_checked(ppaas: CommandLine, home: Path, option: tuple[str, str]) -> None:
    refused = await ppaas("map", "import", str(home), *option, user=None)
    assert refused.status == 2


async def test_a_file_that_is_too_large_is_not_read(ppaas: CommandLine, tmp_path: Path) -> None:
    file = tmp_path / "hall.pcd"
    with file.open("wb") as opened:
        opened.truncate(MAX_FILE + 1)
    refused = await ppaas("map", "import", str(file), "--dry-run")
    assert refused.status == 1
    assert f"hall.pcd has {MAX_FILE + 1} bytes; at most {MAX_FILE} are allowed" in refused.err
