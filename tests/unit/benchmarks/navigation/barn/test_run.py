import pytest

from benchmarks.navigation.barn import run
from benchmarks.navigation.barn.run import BarnJob, BarnResult, drive
from ppaas.messages.geometry_msgs import Twist, Vector3
from tests.support.world import barn


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
