"""Duplicates: identities at two positions that are one person, and two people who are not."""

from collections.abc import Sequence

import msgspec
import numpy as np
import pytest

from benchmarks.people.report_world import AROUND, ReportingRobot, ReportWorld
from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D
from ppaas.messages.geometry_msgs import Point
from ppaas.messages.people_coordination import PeopleReport
from ppaas.people.coordinator.coordinator import PeopleCoordinator
from ppaas.people.coordinator.duplicates import Duplicates
from ppaas.people.coordinator.people_table import PeopleTable
from tests.support.world.rooms import room

Pairs = list[tuple[int, int]]


def found(apart: Sequence[tuple[float, float]], speed: float = 0.0, deviation: float = 0.1) -> Pairs:
    """Return the duplicates after 4 s, of pairs with these differences [m], each side seen by a robot of its own."""
    duplicates, pairs = Duplicates(), []
    for step in range(20):
        table, now = PeopleTable(), 0.2 * step
        for number, (x, y) in enumerate(apart):
            at = np.array([[speed * now, 10.0 * number], [speed * now + x, 10.0 * number + y]])
            table.begin(at, np.tile(0.01 * np.eye(2), (2, 1, 1)), now)
        for row, person in enumerate(table.rows):
            person.seen_by, person.deviation = {"ab"[row % 2]: "torso"}, deviation
        pairs = duplicates.find(table, now, lambda rows: [True] * len(rows))
    return pairs


def test_two_who_stand_a_metre_apart_are_not_one_person_as_the_robots_know_where_they_are() -> None:
    assert found([(0.9, 0.0)]) == []


@pytest.mark.parametrize(
    ("apart", "speed", "deviation"),
    [([(0.9, 0.0)], 0.5, 0.1), ([(0.9, 0.0)], 0.0, 0.6), ([(0.2, 0.0)], 0.0, 0.1)],
    ids=["they walk with the same difference", "the robots are that uncertain", "there is no room for two"],
)
def test_two_identities_are_one_person_if(apart: list[tuple[float, float]], speed: float, deviation: float) -> None:
    assert found(apart, speed, deviation) == [(1, 2)]


def test_two_pairs_with_the_same_difference_are_two_people_though_they_stand() -> None:
    assert sorted(found([(0.9, 0.3), (0.9, 0.3)])) == [(1, 2), (3, 4)]


HALL = build_layers(room(16.0, 10.0)).costmap
NOW = 1_700_000_000.0


def with_second(report: PeopleReport, *, alone: bool) -> PeopleReport:
    """Return a report with a second torso 0.3 m beside each person, or with the second ones alone."""
    second = [
        msgspec.structs.replace(each, object_id=f"{each.object_id}0", name="", pos=Point(each.pos.x + 0.3, each.pos.y))
        for each in report.people
    ]
    return msgspec.structs.replace(report, people=second if alone else [*report.people, *second])


def test_a_person_whom_a_robot_detects_twice_in_turn_keeps_one_identity() -> None:
    robot = ReportingRobot("a", Pose2D(3.0, 5.0, 0.0), view=AROUND)
    world, coordinator = ReportWorld(HALL, 1, [robot], detected=1.0), PeopleCoordinator(HALL)
    world.people = np.array([[6.0, 6.0]])
    for cycle in range(40):
        now = NOW + cycle / 5
        report = world.report(robot, now)
        coordinator.report(report if cycle < 10 else with_second(report, alone=cycle % 7 > 3), now)
        state = coordinator.step(now)
        assert cycle < 5 or [person.id for person in state.people] == [1]
    assert state.count == 1
