"""Verb ``ppaas building plan``: the legs of a route, its picture, and what it refuses."""

import json
from pathlib import Path

import pytest
from PIL import Image

from tests.support.cloud.command_line import CommandLine
from tests.support.rmf import building

ENDS = ("L1:5,5", "L2:5,5,1.5")


@pytest.fixture
async def line(ppaas: CommandLine, tmp_path: Path) -> CommandLine:
    """Return the command line of ann, who has imported a building of two floors with one lift."""
    file = tmp_path / "inn.building.yaml"
    file.write_bytes(building())
    answer = await ppaas("building", "import", str(file))
    assert answer.status == 0, answer.err
    return ppaas


async def test_the_legs_of_a_route_are_listed(line: CommandLine) -> None:
    answer = await line("building", "plan", "inn", *ENDS, "--speed", "1", "--alternatives", "1")
    assert answer.status == 0, answer.err
    kinds = [row[0] for row in answer.rows[1:-1]]
    assert kinds[0] == kinds[-1] == "drive"
    assert "lift" in kinds
    assert answer.out.splitlines()[-1].endswith(" m by north")
    found = json.loads((await line("building", "plan", "inn", *ENDS, "--json")).out)
    assert found["takes"] == ["north"]
    assert found["legs"][-1]["goal"] == [5.0, 5.0, 1.5]


async def test_a_route_is_drawn_on_its_floors(line: CommandLine, tmp_path: Path) -> None:
    plain, drawn = tmp_path / "layout.png", tmp_path / "plan.png"
    assert (await line("building", "layout", "inn", "--picture", str(plain))).status == 0
    assert (await line("building", "plan", "inn", *ENDS, "--picture", str(drawn))).status == 0
    with Image.open(plain) as one, Image.open(drawn) as other:
        assert one.size == other.size
        assert one.tobytes() != other.tobytes()


async def test_a_lift_to_avoid_and_unknown_places_are_refused(line: CommandLine) -> None:
    refused = await line("building", "plan", "inn", *ENDS, "--avoid", "north")
    assert refused.status == 1
    assert "no route leads from" in refused.err
    for words, reason in (
        (("5,5", "L2:1,1"), "FLOOR:X,Y"),
        (("L1:5", "L2:1,1"), "FLOOR:X,Y"),
        (("L1:5,5,0,0", "L2:1,1"), "not more"),
        ((*ENDS, "--label", "legs"), "NAME=VALUE"),
        ((*ENDS, "--closed", "L1"), "FLOOR:DOOR"),
        ((*ENDS, "--closed", "L1:gate"), "has no door 'gate'"),
        ((*ENDS, "--picture", "plan.jpg"), ".png"),
    ):
        answer = await line("building", "plan", "inn", *words)
        assert answer.status == 1, words
        assert reason in answer.err
