"""Rules on localization."""

import pytest

from ppaas.diagnosis.observations.facts import PlaceFacts
from ppaas.diagnosis.rules.place import place
from ppaas.diagnosis.rules.scans import BLIND
from tests.support.world.diagnosed_robot import healthy, with_topic

GOOD = {
    "pose": (1.0, 2.0, 0.0), "silence": 0.1, "deviation": 0.05, "turn_deviation": 0.02, "explained": 0.95,
    "cell": "free", "clearance": 0.8, "radius": 0.2,
}  # fmt: skip


@pytest.mark.parametrize(
    ("changed", "kinds"),
    [
        ({}, []),
        ({"problem": "scans are refused: unknown frame 'x'"}, ["localization-without-scans"]),
        ({"pose": None, "silence": None}, ["localization-silent"]),
        ({"silence": 9.0}, ["localization-silent"]),
        ({"deviation": 0.8}, ["localization-unsure"]),
        ({"deviation": 4.0}, ["localization-lost"]),
        ({"explained": 0.1}, ["localization-lost"]),
        ({"explained": 0.4}, ["localization-fit"]),
        ({"explained": None, "deviation": None}, []),
        ({"cell": "outside", "clearance": None}, ["pose-outside-map"]),
        ({"cell": "occupied", "clearance": 0.0}, ["pose-in-obstacle"]),
        ({"barrier": "the keep-out zone 'spill'"}, ["pose-in-zone"]),
        ({"cell": "unknown"}, ["pose-in-unknown"]),
        ({"clearance": 0.15}, ["footprint-in-obstacle"]),
    ],
)
def test_each_state_of_localization_has_its_finding(changed: dict[str, object], kinds: list[str]) -> None:
    found = list(place(healthy(place=PlaceFacts(**GOOD | changed))))
    assert [finding.kind for finding in found] == kinds
    assert all(finding.advice for finding in found)


def test_missing_sensors_are_the_cause_of_a_missing_pose() -> None:
    assert list(place(healthy(topics=[], place=PlaceFacts()))) == []


def test_refused_scans_are_left_to_the_rule_on_refusals() -> None:
    seen = with_topic("scan", refused=4)
    seen.place = PlaceFacts(problem="scans are refused: x")
    assert list(place(seen)) == []


def test_scans_without_readings_are_left_to_the_rule_on_ranges() -> None:
    assert list(place(healthy(makes_map=True, place=PlaceFacts(problem=f"{BLIND}All ranges are infinite.")))) == []


def test_robot_that_makes_a_map_is_told_so() -> None:
    [finding] = place(healthy(makes_map=True, place=PlaceFacts(**GOOD)))
    assert (finding.kind, finding.level) == ("makes-map", "ok")


@pytest.mark.parametrize("way", ["follows_paths", "localizes_itself"])
def test_a_robot_that_localizes_itself_is_judged_by_its_own_words(way: str) -> None:
    problem = "states of the AGV are left out: late message 3 on state"
    seen = healthy(topics=[], **{way: True}, place=PlaceFacts(**GOOD | {"problem": problem}))
    [finding] = place(seen)
    assert (finding.kind, finding.level) == ("not-localized", "error")
    assert problem in finding.text
    standing = PlaceFacts(**GOOD | {"silence": 3.0, "explained": None})
    assert list(place(healthy(topics=[], **{way: True}, place=standing))) == []
    silent = PlaceFacts(**GOOD | {"silence": 9.0})
    assert [one.kind for one in place(healthy(topics=[], **{way: True}, place=silent))] == ["not-localized"]


def test_scans_that_stopped_are_named_once() -> None:
    seen = with_topic("scan", silence=7.0)
    seen.place = PlaceFacts(problem="no scan comes any more")
    assert list(place(seen)) == []
