"""Second torsos: a detector finds a person twice, side by side, and sometimes only at the second place."""

import msgspec
import numpy as np

from benchmarks.people.report_world import AROUND, ReportingRobot, ReportWorld
from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D
from ppaas.messages.geometry_msgs import Point
from ppaas.messages.people_coordination import PeopleReport
from ppaas.people.coordinator.coordinator import Coordinator
from tests.support.world.rooms import room

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
    world, coordinator = ReportWorld(HALL, 1, [robot], detected=1.0), Coordinator(HALL)
    world.people = np.array([[6.0, 6.0]])
    for cycle in range(40):
        now = NOW + cycle / 5
        report = world.report(robot, now)
        coordinator.report(report if cycle < 10 else with_second(report, alone=cycle % 7 > 3), now)
        state = coordinator.step(now)
        assert cycle < 5 or [person.id for person in state.people] == [1]
    assert state.count == 1
