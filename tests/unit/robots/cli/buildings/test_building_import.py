"""Verb ``ppaas building import``: a building of Open-RMF with its drawings."""

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ppaas.maps.formats.map_files import load_map
from ppaas.zones.reading import zones_of
from ppaas.zones.zone import LiftCar
from tests.support.cloud.command_line import CommandLine
from tests.support.rmf import building, floor


@pytest.fixture
def file(tmp_path: Path) -> Path:
    found = tmp_path / "inn.building.yaml"
    found.write_bytes(building())
    return found


def draw(file: Path) -> None:
    """Write a building of one floor with a drawing of its outer walls."""
    file.write_bytes(building(levels={"L1": floor(drawing={"filename": "L1.png"})}, lifts={}))
    greys = np.full((160, 240), 255, np.uint8)
    greys[:4], greys[-4:], greys[:, :4], greys[:, -4:] = 0, 0, 0, 0
    Image.fromarray(greys).save(file.parent / "L1.png")


async def test_a_dry_run_prints_what_it_would_make(ppaas: CommandLine, file: Path, tmp_path: Path) -> None:
    picture = tmp_path / "inn.png"
    answer = await ppaas("building", "import", str(file), "--dry-run", "--picture", str(picture))
    assert answer.rows[1] == ["L1", "inn-L1", "0", "0,", "0,", "0"]
    assert answer.rows[2][:3] == ["L2", "inn-L2", "4"]
    assert "0 refused" in answer.err
    with Image.open(picture) as drawn:
        assert drawn.width > drawn.height
    as_json = await ppaas("building", "import", str(file), "--dry-run", "--json", "--id", "tavern")
    assert json.loads(as_json.err)["counts"]["refused"] == 0
    made = json.loads(as_json.out)
    assert [each["map"] for each in made["building"]["floors"]] == ["tavern-L1", "tavern-L2"]
    assert made["warnings"] == []
    assert ppaas.services.store.buildings("ann") == []


async def test_maps_with_zones_and_the_building_are_published(ppaas: CommandLine, file: Path) -> None:
    answer = await ppaas("building", "import", str(file), "--message", "survey of May", "--reader", "*")
    assert answer.status == 0, answer.err
    assert answer.rows[1][:3] == ["inn", "ann", "1"]
    for map_id in ("inn-L1", "inn-L2"):
        with ppaas.services.map_store.open_map(map_id) as opened:
            assert (opened.record.readers, opened.record.present.message) == (("*",), "survey of May")
            assert any(isinstance(zone.rule, LiftCar) for zone in zones_of(bytes(opened.buffers["zones"])).zones)
    again = await ppaas("building", "import", str(file))
    assert again.rows[1][:3] == ["inn", "ann", "1"], "what is equal adds no version"


async def test_drawings_beside_the_file_are_taken(ppaas: CommandLine, file: Path) -> None:
    draw(file)
    answer = await ppaas("building", "import", str(file))
    assert answer.status == 0, answer.err
    with ppaas.services.map_store.open_map("inn-L1") as opened:
        yaml, image = opened.grid()
        grid = load_map(yaml, bytes(image))
    assert (grid.info.width, grid.info.height) == (240, 160)
    assert (grid.info.origin.x, grid.info.origin.y) == pytest.approx((0.0, -8.0))


async def test_names_that_cannot_be_ids_and_files_that_cannot_be_read_are_refused(
    ppaas: CommandLine, tmp_path: Path
) -> None:
    missing = await ppaas("building", "import", str(tmp_path / "inn.building.yaml"), "--dry-run")
    assert missing.status == 1 and "cannot read the building" in missing.err
    odd = await ppaas("building", "import", str(tmp_path / "my inn.building.yaml"), "--dry-run")
    assert odd.status == 1 and "--id my-inn" in odd.err
