"""Reports of robots."""

import math
from typing import Any

import msgspec
import pytest

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point, Pose, PoseWithCovariance
from ppaas.messages.people_coordination import PeopleReport, SensorView
from ppaas.messages.people_msgs import PositionMeasurement
from ppaas.people.coordinator.reports import (
    MOST_OF_POSE,
    UNKNOWN_VARIANCE,
    detected_twice,
    read_report,
)

HEADER = Header(stamp=Time.of(100.0), frame_id="map")
PERSON = PositionMeasurement(HEADER, "a/1", "1", Point(2.0, 1.0))
REPORT = PeopleReport(HEADER, "a", PoseWithCovariance(Pose.of(Pose2D(1.0, 2.0, 0.5))), [PERSON])


def changed(**fields: Any) -> PeopleReport:
    return msgspec.structs.replace(REPORT, **fields)


def person(**fields: Any) -> PeopleReport:
    return changed(people=[msgspec.structs.replace(PERSON, **fields)])


def pose(value: float) -> PeopleReport:
    return changed(pose=PoseWithCovariance(REPORT.pose.pose, [value] + [0.0] * 35))


def test_a_report_is_read_as_arrays() -> None:
    read = read_report(REPORT)
    assert (read.robot, read.stamp, read.ids, read.frames) == ("a", 100.0, ["1"], ["a/1"])
    assert read.torsos.tolist() == [[2.0, 1.0]]
    assert read.covariances[0].tolist() == [[UNKNOWN_VARIANCE, 0.0], [0.0, UNKNOWN_VARIANCE]]


@pytest.mark.parametrize(
    ("report", "reason"),
    [
        (changed(robot=""), "name its robot"),
        (pose(math.nan), "finite"),
        (pose(-1.0), "negative"),
        (changed(pose=PoseWithCovariance(Pose.of(Pose2D(1e300, 0.0, 0.0)))), "within 100000 m"),
        (person(pos=Point(math.inf, 0.0)), "finite"),
        (person(pos=Point(1e4, 0.0)), "within"),
        (person(reliability=math.nan), "finite"),
        (person(covariance=[-1.0] + [0.0] * 8), "negative"),
        (changed(people=[PERSON, PERSON]), "different ids"),
        (changed(people=[msgspec.structs.replace(PERSON, object_id=str(k)) for k in range(201)]), "up to 200"),
        (changed(views=[SensorView(0.0, 0.0, 0.0, math.nan, 0.0, 5.0)]), "view"),
        (changed(views=[SensorView(0.0, 0.0, 0.0, 1.0, 0.0, 1e300)]), "up to 100000"),
        (changed(views=[SensorView(0.0, 0.0, 0.0, 1.0, 0.0, 5.0)] * 17), "up to 16"),
    ],
)
def test_a_report_that_is_wrong_is_refused_with_the_reason(report: PeopleReport, reason: str) -> None:
    with pytest.raises(InvalidInput, match=reason):
        read_report(report)


def test_a_huge_variance_of_a_pose_is_limited_and_impossible_correlations_are_left_out() -> None:
    assert read_report(pose(1e300)).pose_covariance.tolist() == [[MOST_OF_POSE, 0.0, 0.0], [0.0] * 3, [0.0] * 3]
    covariance = [0.0] * 36
    covariance[0], covariance[1], covariance[6], covariance[7] = 0.01, 0.5, 0.5, 0.01
    read = read_report(changed(pose=PoseWithCovariance(REPORT.pose.pose, covariance)))
    assert read.pose_covariance.tolist() == [[0.01, 0.0, 0.0], [0.0, 0.01, 0.0], [0.0] * 3]


def test_possible_correlations_of_a_pose_are_kept() -> None:
    covariance = [0.0] * 36
    covariance[0], covariance[5], covariance[30], covariance[35] = 0.04, 0.01, 0.01, 0.01
    read = read_report(changed(pose=PoseWithCovariance(REPORT.pose.pose, covariance)))
    assert read.pose_covariance.tolist() == [[0.04, 0.0, 0.01], [0.0] * 3, [0.01, 0.0, 0.01]]


@pytest.mark.parametrize(
    ("bound", "second"), [({}, "2"), ({"2": 5}, "1"), ({"1": 5, "2": 7}, "2"), ({"1": 7, "2": 5}, "1")]
)
def test_of_two_torsos_nearer_than_people_stand_the_better_known_one_is_kept(
    bound: dict[str, int], second: str
) -> None:
    at = {"1": (2.0, 0.95), "2": (2.2, 0.8), "3": (2.6, 0.9)}
    people = [
        msgspec.structs.replace(PERSON, object_id=name, pos=Point(*place), reliability=score)
        for (name, place), score in zip(at.items(), (0.9, 0.7, 0.8), strict=True)
    ]
    report = read_report(changed(people=people))
    left_out = detected_twice(report, bound)
    assert [name for name, out in zip(report.ids, left_out, strict=True) if out] == [second]
    assert report.without(left_out).outside == 0
