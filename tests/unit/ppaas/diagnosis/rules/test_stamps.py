"""Rules on stamps."""

import pytest

from ppaas.diagnosis.rules.frames import stamps
from tests.support.world.diagnosed_robot import healthy, with_topic


def test_stamps_of_a_healthy_robot_are_in_order() -> None:
    assert list(stamps(healthy())) == []


@pytest.mark.parametrize(("late", "word"), [(40.0, "40.0 s behind"), (-3600.0 * 5, "5 h ahead of")])
def test_clock_that_differs_is_told_with_its_size_and_side(late: float, word: str) -> None:
    seen = healthy()
    seen.topics = [with_topic("scan", late=late).topic("scan"), with_topic("odom", late=late).topic("odom")]
    [finding] = stamps(seen)
    assert (finding.kind, finding.level) == ("clock-skew", "warn")
    assert f"The robot's clock is {word} the cloud's" in finding.text
    assert "NTP" in finding.advice


def test_stamps_since_the_start_of_a_simulation_are_no_skew_of_decades() -> None:
    seen = healthy(topics=[with_topic("odom", late=1.7e9).topic("odom")])
    assert [finding.kind for finding in stamps(seen)] == ["stamps-not-epoch"]


@pytest.mark.parametrize(("late", "level"), [(0.5, "warn"), (3.0, "error"), (-3.0, "error")])
def test_scans_by_another_clock_than_odometry_are_found(late: float, level: str) -> None:
    [finding] = stamps(with_topic("scan", late=late))
    assert (finding.kind, finding.level) == ("scan-odom-clocks", level)
    assert ("before" if late > 0 else "ahead of") in finding.text


@pytest.mark.parametrize(
    ("changed", "kind", "level"),
    [
        ({"unstamped": 1.0}, "stamps-zero", "ok"),
        ({"unstamped": 0.3}, "stamps-mixed", "warn"),
        ({"backwards": 3}, "stamps-backwards", "warn"),
    ],
)
def test_stamps_that_are_zero_or_run_backwards_are_found(changed: dict[str, float], kind: str, level: str) -> None:
    [finding] = stamps(with_topic("odom", **changed))
    assert (finding.kind, finding.level, finding.topic) == (kind, level, "odom")
