"""Commands of from-valetudo.md work, and its table has what the import does."""

import json
import re
from pathlib import Path

import pytest

from ppaas.imports.maps.household import valetudo
from tests.support.cloud.cloud import RunningCloud
from tests.support.documents import run_shell, script, table

PAGE = "docs/from-valetudo.md"

FLOOR = [value for row in range(40, 100) for value in (20, row, 80)]
WALLS = [20, 39, 80, 20, 100, 80, *(value for row in range(39, 101) for value in (19, row, 1, 100, row, 1))]
HOME = {
    "__class": "ValetudoMap",
    "metaData": {"version": 2},
    "size": {"x": 600, "y": 600},
    "pixelSize": 5,
    "layers": [
        {"type": "segment", "metaData": {"segmentId": "1", "name": "hall"}, "pixels": [], "compressedPixels": FLOOR},
        {"type": "wall", "metaData": {}, "pixels": [], "compressedPixels": WALLS},
    ],
    "entities": [
        {"type": "virtual_wall", "metaData": {}, "points": [300, 200, 300, 300]},
        {"type": "charger_location", "metaData": {}, "points": [150, 250]},
    ],
}


def test_the_table_has_all_that_the_import_knows() -> None:
    rows = table(PAGE, "in Valetudo", "here")
    named = {name: meaning for cell, meaning in rows for name in re.findall(r"\w+", cell)}
    assert {*valetudo.FREE_LAYERS, *valetudo.OCCUPIED_LAYERS, *valetudo.UNUSED} <= named.keys()
    assert all("no effect" in named[name] for name in valetudo.UNUSED)
    assert f"{valetudo.WALL_WIDTH:g} m wide" in named["virtual_wall"]


@pytest.mark.journey
def test_the_shell_commands_work(cloud: RunningCloud, tmp_path: Path) -> None:
    (tmp_path / "home.json").write_text(json.dumps(HOME))
    [login] = [line for line in script("README.md").splitlines() if line.startswith("export PPAAS_TOKEN")]
    printed = run_shell(f"{login}\n{script(PAGE)}", tmp_path, cloud)
    assert "virtual wall 0  keep_out" in printed
    [length] = re.findall(r"dijkstra\s+([\d.]+)", printed)
    assert float(length) > 2.9, "the way around the virtual wall, which ends at y = 3 m"
    assert (tmp_path / "home.png").is_file()
