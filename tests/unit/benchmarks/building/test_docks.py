"""Bench of docks."""

import msgspec

from benchmarks.building.docks import DocksReport, measure_docks


def test_a_few_goals_charge_the_robot() -> None:
    done: list[None] = []
    report = measure_docks(3, seed=3, advance=lambda: done.append(None))
    assert (report.goals, report.charged, report.wrong, report.idle) == (3, 3, 0, 0)
    assert report.passed
    assert len(done) == 3
    assert report.rows()[0]["charge confirmed"] == "100.00 %"


def test_goals_that_leave_a_robot_without_charge_miss_the_bars() -> None:
    good = DocksReport(1000, 995, 0, 0, 0.2, 12.0, 200, 50, {"dock 'a' is not seen": 5})
    assert good.passed
    assert good.sentences()[1] == "5 times: dock 'a' is not seen"
    for missed in ({"charged": 994}, {"wrong": 1}, {"idle": 1}, {"retries": 1.01}):
        assert not msgspec.structs.replace(good, **missed).passed, missed
