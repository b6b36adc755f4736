from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from benchmarks.navigation.barn import picture
from benchmarks.navigation.barn.run import BarnResult
from benchmarks.navigation.barn.worlds import START
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from tests.support.world import barn, grids

RESULT = BarnResult(7, 0, "success", 5.0, 5.1, 0.2)


def test_the_picture_shows_cylinders_path_and_obstacle_cells() -> None:
    world, costs = barn.world(), np.zeros((40, 40), np.uint8)
    costs[30, 20] = 254
    poses = [START @ Pose2D(0.1 * step, 0.0) for step in range(40)]
    [axes] = picture.draw(world, poses, grids.of(costs, 0.05, Pose2D(1.0, -1.0)), RESULT).axes
    assert len(axes.patches) == len(world.cylinders) + 1  # and the goal
    *outlines, path = axes.lines
    assert path.get_xydata().tolist() == [[pose.x, pose.y] for pose in poses]
    assert len(outlines) == len(poses[:: round(picture.OUTLINE_PERIOD / picture.PERIOD)])
    cells = np.asarray(axes.images[0].get_array())
    assert cells[30, 20].tolist() == [*picture.LETHAL, 255]
    assert cells[..., 3].sum() == 255
    assert "success after" in axes.get_title()


def test_an_unwritable_picture_is_refused(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(picture, "drive", lambda job, watch: RESULT)
    job = type("BarnJob", (), {"world": barn.world()})()
    with pytest.raises(InvalidInput, match="cannot write"):
        picture.write_picture(tmp_path / "no" / "run.png", job)
    picture.write_picture(tmp_path / "run.png", job)
    with Image.open(tmp_path / "run.png") as image:
        assert image.height > image.width
