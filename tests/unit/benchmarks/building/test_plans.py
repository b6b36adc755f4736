"""Bench of plans over floors."""

import msgspec

from benchmarks.building.plans import measure_plans


def test_a_small_tower_is_planned_exactly_and_bars_count() -> None:
    done: list[None] = []
    report = measure_plans(2, 320, 12, 6, lambda: done.append(None))
    assert (report.queries, report.checked, report.wrong, report.lifts, report.doors) == (12, 6, 0, 4, 4)
    assert len(done) == 5
    assert report.rows()[0]["floors"] == "2 of 320²"
    quick = msgspec.structs.replace(report, plan_us=49.0, floor_us=14.0, door_ms=1.9)
    assert quick.passed
    for missed in ({"plan_us": 51.0}, {"floor_us": 16.0}, {"door_ms": 2.1}, {"wrong": 1}):
        assert not msgspec.structs.replace(quick, **missed).passed, missed
