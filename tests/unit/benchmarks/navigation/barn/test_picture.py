from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from benchmarks.navigation.barn import picture
from benchmarks.navigation.barn.run import Result
from benchmarks.navigation.barn.worlds import START
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from tests.support.world import barn, grids

RESULT = Result(7, 0, "success", 5.0, 5.1, 0.2)


def test_it_shows_cylinders_the_way_and_what_was_seen() -> None:
    costs = np.zeros((40, 40), np.uint8)
    costs[30, 20] = 254
    poses = [START @ Pose2D(0.1 * step, 0.0) for step in range(40)]
    drawn = picture.draw(barn.world(), poses, grids.of(costs, 0.05, Pose2D(1.0, -1.0)), RESULT)
    colours = {colour for _, colour in drawn.getcolors(1 << 16)}
    assert {picture.CYLINDER, picture.WAY, picture.THERE, picture.SEEN} <= colours


def test_a_picture_that_cannot_be_written_is_refused(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(picture, "drive", lambda job, watch: RESULT)
    job = type("Job", (), {"world": barn.world()})()
    with pytest.raises(InvalidInput, match="cannot write"):
        picture.write_picture(tmp_path / "no" / "run.png", job)
    picture.write_picture(tmp_path / "run.png", job)
    with Image.open(tmp_path / "run.png") as image:
        assert image.height > image.width
