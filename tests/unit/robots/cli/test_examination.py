"""View of a diagnosis as text."""

from robots.cli.examination import WIDTH, as_text

TOPIC = {
    "name": "scan", "type": "sensor_msgs/LaserScan", "count": 9, "rate": 10.04, "bandwidth": 2.1e4, "size": 2.1e3,
    "silence": 0.04, "late": 0.021, "refused": 3,
}  # fmt: skip
SILENT = TOPIC | {
    "name": "odom",
    "silence": None,
    "late": None,
    "rate": 0.0,
    "size": 0.0,
    "bandwidth": 0.0,
    "refused": 0,
}


def finding(level: str, text: str, advice: str = "") -> dict[str, str]:
    return {"level": level, "kind": "k", "text": text, "advice": advice, "topic": ""}


def report(*findings: dict[str, str], **more: object) -> dict[str, object]:
    return {"robot": "tb1", "connected": True, "level": "ok", "seconds": 3.0, "findings": list(findings)} | more


def test_findings_are_wrapped_below_their_level_with_the_advice() -> None:
    text = as_text(report(finding("error", "No scan has come. " * 10, "Publish it. " * 10), finding("warn", "Slow.")))
    lines = text.splitlines()
    assert lines[0] == "tb1: 1 error, 1 warning (watched for 3.0 s)"
    assert lines[2].startswith("ERROR  No scan has come.")
    assert any(line.startswith("       → Publish it.") for line in lines)
    assert "WARN   Slow." in lines
    assert max(map(len, lines)) <= WIDTH


def test_topics_of_a_connected_robot_are_a_table() -> None:
    lines = as_text(report(topics=[TOPIC, SILENT])).splitlines()
    assert lines[2] == "OK     Everything that the cloud checks is in order."
    assert " ".join(lines[-2].split()) == "scan sensor_msgs/LaserScan 10 Hz 2 kB 21 kB/s 0.0 s ago 0.0 s 3"
    assert " ".join(lines[-1].split()) == "odom sensor_msgs/LaserScan - - - never - -"


def test_frames_are_listed_with_their_parents() -> None:
    frames = [{"name": "laser", "parent": "base_link", "static": True, "silence": 1.0}]
    assert as_text(report(frames=frames)).splitlines()[-1] == "frames: base_link → laser (static)"


def test_control_characters_of_a_robot_do_not_reach_the_terminal() -> None:
    assert "\x1b" not in as_text(report(finding("error", "frame \x1b[2J"), robot="\x1b]0;x"))


def test_cloud_is_named_by_its_url() -> None:
    text = as_text({"cloud": "http://c", "level": "ok", "findings": [finding("ok", "It answers.")], "robots": []})
    assert text == "cloud http://c: all is well\n\nOK     It answers.\n"
