"""Rules on a robot that is not connected."""

import pytest

from ppaas.diagnosis.observations.facts import AbsenceFacts
from ppaas.diagnosis.rules.link import absence

FREE = {"robot": "tb1", "cores": 1.0, "free": (0.5, 4.0)}


@pytest.mark.parametrize(
    ("changed", "kinds"),
    [
        ({}, []),
        ({"refusal": "conflict: it is connected already", "refused_ago": 3.0}, ["connect-refused"]),
        ({"map_problem": "unknown map 'office'"}, ["map-unusable"]),
        ({"quota_problem": "user 'ann' may have 2 containers"}, ["quota"]),
        ({"free": ()}, ["no-machine"]),
        ({"free": (0.5,)}, ["no-capacity"]),
    ],
)
def test_what_would_stop_a_robot_from_connecting_is_named(changed: dict[str, object], kinds: list[str]) -> None:
    found = list(absence(AbsenceFacts(**FREE | changed)))
    assert [finding.kind for finding in found] == [*kinds, "robot-not-connected"]
    assert all(finding.level == "error" and finding.advice for finding in found)


def test_a_robot_that_is_an_agv_is_looked_for_at_its_bridge() -> None:
    *_, finding = absence(AbsenceFacts(robot="fork-7", agv="acme/fork-7", free=(4.0,)))
    assert "which is AGV acme/fork-7" in finding.text
    assert "ppaas bridge agv" in finding.advice
