"""Rules on sensors and scans."""

import msgspec
import pytest

from ppaas.diagnosis.observations.facts import FrameFacts, ScanFacts, TopicFacts
from ppaas.diagnosis.rules.scans import scans
from ppaas.diagnosis.rules.sensors import sensors
from tests.support.world.diagnosed_robot import LINK, healthy, kinds, with_topic


def test_healthy_robot_has_no_finding() -> None:
    assert list(sensors(healthy())) == []


@pytest.mark.parametrize("name", ["scan", "odom"])
@pytest.mark.parametrize(
    ("changed", "kind"),
    [
        ({"silence": None, "count": 0, "rate": 0.0, "late": None, "gap": None}, "missing"),
        ({"silence": 4.0}, "stopped"),
        ({"rate": 2.0}, "slow"),
        ({"gap": 1.8}, "gaps"),
        ({"burst": 0.6}, "bursts"),
        ({"growth": 0.8}, "too-much"),
        ({"size": 120e3}, "large"),
        ({"bandwidth": 3e6}, "large"),
    ],
)
def test_each_fault_of_a_sensor_is_found_and_names_its_topic(name: str, changed: dict[str, float], kind: str) -> None:
    [finding] = sensors(with_topic(name, **changed))
    assert (finding.kind, finding.topic) == (f"{name}-{kind}", name)
    assert finding.advice


def test_robot_that_sends_nothing_lacks_scans_and_odometry() -> None:
    assert kinds(list(sensors(healthy(topics=[])))) == ["scan-missing", "odom-missing"]


def test_scans_on_another_topic_are_found_with_the_namespace_to_add() -> None:
    link = msgspec.structs.replace(LINK, client_topics={"robot1/scan": "sensor_msgs/LaserScan", "lidar": "x/Y"})
    seen = healthy(topics=[healthy().topic("odom")], link=link)
    [finding] = sensors(seen)
    assert "'robot1/scan'" in finding.advice
    assert "&namespace=robot1" in finding.advice


def test_odometry_under_another_name_is_found_without_a_namespace() -> None:
    link = msgspec.structs.replace(LINK, client_topics={"wheel_odom": "nav_msgs/Odometry"})
    [finding] = sensors(healthy(topics=[healthy().topic("scan")], link=link))
    assert "'wheel_odom'" in finding.advice
    assert "namespace" not in finding.advice


def test_reason_of_the_cloud_for_a_refused_topic_is_given() -> None:
    link = msgspec.structs.replace(LINK, refused={"scan": "topic 'scan' has type sensor_msgs/LaserScan, not x/Y"})
    [finding] = sensors(healthy(topics=[healthy().topic("odom")], link=link))
    assert "has type sensor_msgs/LaserScan" in finding.advice


def test_odometry_by_tf_alone_is_a_warning() -> None:
    frame = FrameFacts(name="base_link", parents=("odom",), silence=0.1)
    [finding] = sensors(healthy(topics=[healthy().topic("scan")], frames=[frame]))
    assert (finding.kind, finding.level) == ("odom-by-tf-only", "warn")


def test_robot_with_a_depth_camera_is_asked_for_images_first() -> None:
    odom = healthy().topic("odom")
    [finding] = sensors(healthy(topics=[odom], camera=True))
    assert "publish 'camera/depth/image_raw'" in finding.advice
    images = TopicFacts(name="camera/depth/image_raw", count=7)
    [finding] = sensors(healthy(topics=[odom, images], camera=True))
    assert "see the refusals" in finding.advice


def test_refused_messages_are_left_to_the_rule_on_refusals() -> None:
    assert list(sensors(with_topic("scan", silence=None, refused=9))) == []


def test_a_robot_that_localizes_itself_needs_neither_scans_nor_frequent_odometry() -> None:
    assert list(sensors(healthy(topics=[], follows_paths=True))) == []


def test_a_robot_that_localizes_itself_and_obeys_velocities_needs_odometry_and_no_laser() -> None:
    assert [one.kind for one in sensors(healthy(topics=[], localizes_itself=True))] == ["odom-missing"]


GOOD = {"frame": "laser", "beams": 360, "increment": 0.0175, "range_min": 0.12, "range_max": 12.0, "readings": 0.9}


def test_good_scan_has_no_finding() -> None:
    assert list(scans(healthy(scans=[ScanFacts(**GOOD)]))) == []


@pytest.mark.parametrize(
    ("changed", "kind", "words"),
    [
        ({"range_max": 0.0}, "scan-limits", "no range is between"),
        ({"increment": 0.0}, "scan-angles", "one direction"),
        ({"increment": 1.0}, "scan-angles", "more than one turn"),
        ({"excess": -40.0}, "scan-angles", "40 less than"),
        ({"beams": 0}, "scan-empty", "no ranges"),
        ({"readings": 0.0, "zeros": 1.0}, "scan-no-readings", "All ranges of the scans of 'laser' are 0"),
        ({"readings": 0.0, "empty": 1.0}, "scan-no-readings", "null, NaN or infinite"),
        ({"readings": 0.02, "short": 0.9}, "scan-no-readings", "98 % ranges"),
        ({"readings": 0.0}, "scan-no-readings", "outside range_min and range_max"),
        ({"beams": 5}, "scan-few-beams", "5 beams"),
        ({"intensities": 360}, "scan-intensities", "360 intensities"),
    ],
)
def test_each_fault_of_a_scan_is_found(changed: dict[str, float], kind: str, words: str) -> None:
    [finding] = scans(healthy(scans=[ScanFacts(**GOOD | changed)]))
    assert finding.kind == kind
    assert words in finding.text
    assert finding.advice


def test_each_laser_is_judged_alone() -> None:
    found = list(scans(healthy(scans=[ScanFacts(**GOOD), ScanFacts(**GOOD | {"frame": "rear", "beams": 0})])))
    assert ["'rear'" in finding.text for finding in found] == [True]
