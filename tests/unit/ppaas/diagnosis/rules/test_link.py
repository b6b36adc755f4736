"""Rules on the connection, on absent robots and on the cloud."""

import msgspec
import pytest

from ppaas.diagnosis.observations.cloud import CloudFacts, MachineFacts, RobotLine
from ppaas.diagnosis.observations.facts import AbsenceFacts, LinkFacts, NodeFacts, ReportFacts, ScanFacts, TopicFacts
from ppaas.diagnosis.rules.cloud import cloud
from ppaas.diagnosis.rules.link import AGV, absence, link, nodes, refusals, reports
from tests.support.world.diagnosed_robot import LINK, healthy, kinds, with_topic


@pytest.mark.parametrize(
    ("changed", "kind", "words"),
    [
        ({"robots": 0, "operators": 2}, "robot-not-connected", "2 operators"),
        ({"round_trip": 0.6}, "link-slow", "600 ms"),
        ({"dropped": 1}, "link-drops", "1 message to"),
        ({"connects": 9}, "link-reconnects", "9 times"),
        ({"client_topics": {"tb1/cmd_vel": "geometry_msgs/Twist"}}, "topic-namespace", "'tb1/cmd_vel'"),
    ],
)
def test_each_fault_of_the_connection_is_found(changed: dict[str, object], kind: str, words: str) -> None:
    [finding] = link(healthy(link=msgspec.structs.replace(LINK, **changed)))
    assert finding.kind == kind
    assert words in finding.text


def test_topics_of_the_robot_that_look_like_no_topic_of_the_clone_are_its_own() -> None:
    own = {"tb1/battery": "sensor_msgs/BatteryState", "chatter": "std_msgs/String"}
    assert list(link(healthy(link=msgspec.structs.replace(LINK, client_topics=own)))) == []


def test_container_knows_nothing_of_the_connection() -> None:
    assert list(link(healthy(link=None))) == []
    assert list(refusals(healthy(link=None))) == []


def test_refused_sensor_is_an_error_with_its_last_reason() -> None:
    [finding] = refusals(with_topic("scan", refused=50, refusal="the pose is not finite"))
    assert (finding.level, finding.topic) == ("error", "scan")
    assert "50 messages on 'scan'" in finding.text
    assert "the pose is not finite" in finding.text


def test_some_refused_messages_are_a_warning() -> None:
    assert [finding.level for finding in refusals(with_topic("scan", refused=2, refusal="x"))] == ["warn"]


def test_refused_goal_is_a_warning() -> None:
    goal = TopicFacts(name="goal_pose", refused=1, refusal="a goal needs header.frame_id")
    [finding] = refusals(healthy(topics=[*healthy().topics, goal]))
    assert (finding.level, finding.topic) == ("warn", "goal_pose")


def test_scan_with_an_unknown_frame_is_left_to_the_rule_on_frames() -> None:
    seen = with_topic("scan", refused=50, refusal="unknown frame 'laser'; known: base_link")
    seen.scans = [ScanFacts(frame="laser", beams=360)]
    assert list(refusals(seen)) == []


def test_operations_that_the_cloud_refused_are_listed() -> None:
    refused = {"scan": "topic 'scan' has another type", "": "JSON is malformed"}
    found = list(refusals(healthy(link=LinkFacts(robots=1, refused=refused))))
    assert [finding.topic for finding in found] == ["scan", ""]


def test_nodes_on_the_robot_are_a_note_and_lost_ones_a_warning() -> None:
    failed = "it could not be run on the robot: it was too slow"
    homes = [
        NodeFacts(name="amcl", home="robot", wanted="robot"),
        NodeFacts(name="move_base", reasons=(failed,)),
        NodeFacts(name="explore", wanted="robot"),
        NodeFacts(name="map_server"),
    ]
    found = list(nodes(healthy(nodes=homes)))
    assert [finding.kind for finding in found] == ["nodes-on-robot", "node-failed", "node-not-taken"]


def test_reports_of_the_robots_own_programs_are_repeated() -> None:
    own = [
        ReportFacts(name="battery", level=2, text="9.8 V"),
        ReportFacts(name="motor", level=1, text="hot"),
        ReportFacts(name="imu"),
        ReportFacts(name="gps", level=3),
    ]
    found = list(reports(healthy(reports=own)))
    assert [finding.level for finding in found] == ["error", "warn", "warn"]
    assert kinds(found) == ["robot-reports"] * 3
    assert "battery: 9.8 V" in found[0].text


@pytest.mark.parametrize(("level", "word"), [(0, "ok"), (1, "warn"), (2, "error"), (3, "error")])
def test_the_agv_that_a_robot_is_is_shown_in_any_case(level: int, word: str) -> None:
    report = ReportFacts(name=f"acme/7{AGV}", level=level, text="in use (connection ONLINE)")
    [finding] = reports(healthy(reports=[report]))
    assert (finding.kind, finding.level, finding.text) == ("agv", word, "AGV acme/7: in use (connection ONLINE).")


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
