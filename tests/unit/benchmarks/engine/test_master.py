"""Figures of a killed master count what survived and what is missing."""

from typing import Any

from benchmarks.engine.master import PlacedRobot, survived

STATE: dict[str, Any] = {"settings": {"m1": {"max_containers": 3}, "m2": {"draining": True}}, "removed": ["m9"]}
BEFORE = {"r1": PlacedRobot("m1", "c1", "", kept=True), "r2": PlacedRobot("m3", "c2", "")}


def counted(after: dict[str, PlacedRobot], still: dict[str, Any]) -> dict[str, bool | None]:
    return {figure.name: figure.kept for figure in survived(BEFORE, after, STATE, still, 1.0)}


def test_a_master_that_lost_nothing_is_within_all_limits() -> None:
    after = {"r1": PlacedRobot("m3", "c7", "c1"), "r2": PlacedRobot("m1", "c8", ""), "r3": PlacedRobot("m1", "c9", "")}
    assert False not in counted(after, STATE).values()


def test_lost_checkpoints_and_settings_exceed_the_limits() -> None:
    kept = counted({"r1": PlacedRobot("m3", "c7", "")}, {"settings": {"m1": {"max_containers": 4}}, "removed": []})
    assert kept["placements made anew"] is False
    assert kept["checkpoints gone on from"] is False
    assert kept["settings of machines kept"] is False


def test_placements_on_drained_or_removed_machines_exceed_the_limit() -> None:
    for machine in ("m2", "m9"):
        after = {"r1": PlacedRobot(machine, "c7", "c1"), "r2": PlacedRobot("m1", "c8", "")}
        assert counted(after, STATE)["placed where none may be"] is False
