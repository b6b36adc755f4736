"""Faults of lifts and doors: reported once they last, once, and once more when they are over."""

from ppaas.buildings.faults import PATIENCE, FaultChange, FaultWatch, PartName

LIFT, DOOR = PartName("lift", "north"), PartName("door", "gate", "L1")


def test_a_fault_that_lasts_is_reported_once_and_so_is_its_end() -> None:
    watch = FaultWatch()
    assert watch.look({LIFT: "fire", DOOR: ""}, 100.0) == []
    assert watch.look({LIFT: "fire", DOOR: ""}, 100.0 + PATIENCE) == [FaultChange(LIFT, "fire")]
    assert watch.look({LIFT: "fire", DOOR: ""}, 200.0) == []
    assert watch.look({LIFT: "", DOOR: ""}, 200.5) == [FaultChange(LIFT, "")]
    assert watch.look({LIFT: "", DOOR: ""}, 300.0) == []


def test_a_short_fault_is_not_reported_and_its_time_begins_again() -> None:
    watch = FaultWatch()
    watch.look({LIFT: "silent"}, 100.0)
    assert watch.look({LIFT: ""}, 101.0) == []
    watch.look({LIFT: "silent"}, 102.0)
    assert watch.look({LIFT: "silent"}, 101.0 + PATIENCE) == []
    assert watch.look({LIFT: "silent"}, 102.0 + PATIENCE) == [FaultChange(LIFT, "silent")]


def test_another_fault_of_the_same_part_is_reported_too() -> None:
    watch = FaultWatch()
    watch.look({LIFT: "silent"}, 100.0)
    watch.look({LIFT: "silent"}, 110.0)
    watch.look({LIFT: "fire"}, 111.0)
    assert watch.look({LIFT: "fire"}, 120.0) == [FaultChange(LIFT, "fire")]


def test_changes_are_told_in_words() -> None:
    assert FaultChange(LIFT, "lift 'north' is in the mode 'fire'").sentence == "lift 'north' is in the mode 'fire'"
    assert FaultChange(LIFT, "").sentence == "lift 'north' serves again"
    assert FaultChange(DOOR, "").sentence == "door 'gate' of floor 'L1' serves again"
