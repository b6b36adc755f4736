"""Rules on the connection of a robot, its topics, refusals, nodes and reports."""

import msgspec
import pytest

from ppaas.diagnosis.observations.facts import LinkFacts, NodeFacts, ReportFacts, ScanFacts, TopicFacts
from ppaas.diagnosis.rules.link import AGV, link, nodes, refusals, reports
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
