from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from benchmarks.navigation.barn import picture, run
from benchmarks.navigation.barn.run import BarnJob, BarnResult, drive
from benchmarks.navigation.barn.worlds import START
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.messages.geometry_msgs import Twist, Vector3
from tests.support.world import barn, grids


def test_a_run_reaches_the_goal_and_is_reproducible() -> None:
    job = BarnJob(barn.world(), "mppi", "nominal", 3, 0)
    result = drive(job)
    assert result.outcome == "success"
    assert result.clearance > 0.05
    assert result.seconds < 1.2 * result.best_time
    assert drive(job) == result


class Straight:
    """Drives straight ahead at one speed, whatever its input."""

    def __init__(self, speed: float) -> None:
        self._twist = Twist(Vector3(x=speed))

    def drive(self, *inputs: object) -> Twist:
        return self._twist


@pytest.mark.parametrize(("speed", "outcome"), [(2.0, "collision"), (0.0, "timeout")])
def test_driving_straight_collides_and_standing_still_times_out(
    monkeypatch: pytest.MonkeyPatch, speed: float, outcome: str
) -> None:
    monkeypatch.setattr(run, "make_navigator", lambda *inputs: Straight(speed))
    monkeypatch.setattr(run, "TIME_LIMIT", 3.0)
    result = drive(BarnJob(barn.world(), "mppi", "nominal", 3, 0))
    assert result.outcome == outcome
    assert (result.clearance <= 0.0) is (outcome == "collision")


@pytest.mark.parametrize(
    ("outcome", "seconds", "score"),
    [("success", 4.0, 0.5), ("success", 15.0, 1.0 / 3.0), ("success", 90.0, 0.125), ("collision", 4.0, 0.0)],
)
def test_a_success_scores_by_its_time_and_a_failure_scores_zero(outcome: str, seconds: float, score: float) -> None:
    assert BarnResult(1, 0, outcome, seconds, 5.0, 0.1).score == pytest.approx(score)


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
