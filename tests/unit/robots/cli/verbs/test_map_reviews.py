"""Verbs of ``ppaas map`` for versions that wait for a review."""

import json
from pathlib import Path

import pytest
from PIL import Image

from tests.support.cloud.command_line import CommandLine
from tests.support.storage.records import pgm


@pytest.fixture
async def proposed(ppaas: CommandLine, house: Path) -> int:
    """Return the number of a version that waits."""
    await ppaas("map", "publish", str(house))
    house.with_suffix(".pgm").write_bytes(pgm(value=0))
    answer = await ppaas("map", "publish", str(house), "--review", "--message", "a wall", "--json")
    return int(json.loads(answer.out)["number"])


async def test_a_proposed_version_is_listed_drawn_and_approved(
    ppaas: CommandLine, proposed: int, tmp_path: Path
) -> None:
    listed = await ppaas("map", "reviews", "house")
    assert listed.rows[1][0] == str(proposed)
    assert "a wall" in listed.out
    shown = await ppaas("map", "reviews", "house", str(proposed), "--plot", str(tmp_path / "change.png"))
    assert "4×3 at (0, 0)" in shown.out
    assert Image.open(tmp_path / "change.png").size == (4, 3)
    approved = json.loads((await ppaas("map", "approve", "house", "--why", "seen it", "--json")).out)
    assert approved["message"] == "a wall"
    assert (await ppaas("map", "reviews", "house", str(proposed))).out.count("seen it") == 1


async def test_a_proposed_version_is_refused_with_a_reason(ppaas: CommandLine, proposed: int) -> None:
    assert (await ppaas("map", "refuse", "house", str(proposed))).status == 2
    refused = await ppaas("map", "refuse", "house", str(proposed), "--why", "a person", "--json")
    assert json.loads(refused.out)["state"] == "refused"
    failed = await ppaas("map", "approve", "house")
    assert failed.status == 1
    assert "those that wait: none" in failed.err
