"""Rules on a cloud."""

import pytest

from ppaas.diagnosis.observations.cloud import CloudFacts, MachineFacts, RobotLine
from ppaas.diagnosis.rules.cloud import cloud

ROBOT = RobotLine(name="tb1", connected=True, level="ok", text="all is well.")
ROOM = MachineFacts(name="m1", state="ready", capacity=8.0, given=1.0)
GOOD = {
    "url": "http://cloud", "round_trip": 0.004, "version": "0.2.0", "own_version": "0.2.0", "user": "ann",
    "machines": [ROOM], "robots": [ROBOT],
}  # fmt: skip


@pytest.mark.parametrize(
    ("changed", "kinds"),
    [
        ({}, []),
        ({"problem": "connection refused"}, ["cloud-unreachable"]),
        ({"round_trip": 0.9}, ["link-slow"]),
        ({"version": "0.1.0"}, ["versions-differ"]),
        ({"ahead": -30.0}, ["clock-skew"]),
        ({"token_problem": "it expired", "user": "", "robots": []}, ["token"]),
        ({"away": {"map store": "timed out"}}, ["store-away"]),
        ({"disk": "it is full"}, ["disk"]),
        ({"plans_waiting": 4}, ["plans-waiting"]),
        ({"machines": []}, ["no-machine"]),
        ({"machines": None}, []),
        ({"machines": [MachineFacts(name="m1", state="draining", capacity=8.0, given=0.0)]}, ["no-machine"]),
        ({"machines": [MachineFacts(name="m1", state="ready", capacity=8.0, given=8.0)]}, ["no-capacity"]),
        ({"robots": []}, ["no-robots"]),
        ({"robots": [RobotLine(name="tb2", connected=True, level="error", text="No scan.")]}, ["robot"]),
    ],
)
def test_each_fault_of_a_cloud_is_found(changed: dict[str, object], kinds: list[str]) -> None:
    found = cloud(CloudFacts(**GOOD | changed))
    assert [finding.kind for finding in found if finding.level != "ok"] == kinds


def test_well_robots_have_one_line_each() -> None:
    texts = [finding.text for finding in cloud(CloudFacts(**GOOD)) if finding.kind == "robot"]
    assert texts == ["Robot 'tb1': all is well."]
