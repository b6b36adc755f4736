"""Faults of the reports of a robot."""

import math

import pytest

from benchmarks.people.runs.faults import BEGIN, OTHER, REPORT_FAULTS, ROBOT, SET_OFF, fault_of
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point, Pose, PoseWithCovariance
from ppaas.messages.people_coordination import PeopleReport
from ppaas.messages.people_msgs import PositionMeasurement


def report(robot: str = ROBOT, stamp: float = 100.0) -> PeopleReport:
    header = Header(stamp=Time.of(stamp), frame_id="map")
    people = [PositionMeasurement(header, f"{robot}/{n}", str(n), Point(float(n), 0.0)) for n in (1, 2)]
    return PeopleReport(header, robot, PoseWithCovariance(Pose.of(Pose2D(1.0, 2.0))), people)


@pytest.mark.parametrize("name", REPORT_FAULTS)
def test_reports_of_other_robots_arrive_unchanged(name: str) -> None:
    told = report("r0")
    assert fault_of(name)(told, 2 * BEGIN) == [told]


def test_a_run_without_a_fault_has_none() -> None:
    told = report()
    assert fault_of("")(told, 2 * BEGIN) == [told]


def test_a_robot_that_disagrees_is_one_metre_off() -> None:
    (moved,) = fault_of("disagree")(report(), BEGIN)
    assert moved.pose.pose.planar().distance_to(Pose2D(1.0, 2.0)) == pytest.approx(1.0)


def test_a_robot_that_lies_tells_of_three_people_who_do_not_exist() -> None:
    (told,) = fault_of("lies")(report(), BEGIN)
    assert len({person.object_id for person in told.people}) == 3


def test_a_robot_that_leaves_is_silent_and_one_that_freezes_repeats_itself() -> None:
    assert fault_of("leaves")(report(), BEGIN) == []
    frozen = fault_of("freezes")
    assert frozen(report(stamp=100.0), BEGIN - 1.0) == frozen(report(stamp=105.0), BEGIN + 4.0)


def test_numbers_that_are_none_are_of_people_or_of_the_robot() -> None:
    fault = fault_of("nan")
    (told,) = fault(report(), BEGIN)
    assert math.isnan(told.people[0].pos.x)
    (alone,) = fault(PeopleReport(Header(), ROBOT, PoseWithCovariance(Pose.of(Pose2D(0.0, 0.0)))), BEGIN)
    assert math.isnan(alone.pose.pose.position.x)


def test_ids_are_given_to_other_people_after_ten_seconds() -> None:
    fault = fault_of("ids")
    (before,), (after,) = fault(report(), BEGIN), fault(report(), BEGIN + 10.0)
    assert [person.object_id for person in before.people] == ["1", "2"] == [p.object_id for p in after.people]
    assert before.people[0].pos == after.people[1].pos


def test_two_clocks_are_off_in_both_directions() -> None:
    fault = fault_of("clocks")
    (ahead,), (behind,) = fault(report(), 0.0), fault(report(OTHER), 0.0)
    assert ahead.header.stamp.seconds() - behind.header.stamp.seconds() == pytest.approx(2 * SET_OFF)
