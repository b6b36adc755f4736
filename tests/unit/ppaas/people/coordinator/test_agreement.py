"""Comparison of robots with the map and with each other."""

import numpy as np

from benchmarks.people.report_world import AROUND
from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point, Pose, PoseWithCovariance
from ppaas.messages.people_coordination import PeopleReport
from ppaas.messages.people_msgs import PositionMeasurement
from ppaas.people.coordinator.agreement import RobotComparison
from ppaas.people.coordinator.group import ALONE, WALLS, Robots
from ppaas.people.coordinator.parameters import CoordinatorParameters
from ppaas.people.coordinator.people_table import PeopleTable
from ppaas.people.coordinator.reports import read_report
from ppaas.people.coordinator.sightings import observe
from ppaas.people.coordinator.visibility import Walls, view_of
from tests.support.world.planar_world import walled_map

HALL = Walls(build_layers(walled_map(12, 8, [])).costmap)
DIVIDED = Walls(build_layers(walled_map(12, 8, [(5.9, 0.0, 6.1, 8.0)])).costmap)
NOW = 1_700_000_000.0


def reasons(walls: Walls, **people: tuple[float, float] | None) -> dict[str, str]:
    """Return why robots at the left are not trusted, after all comparisons, by the person that each sees."""
    table, robots = PeopleTable(), Robots(10.0)
    for number, (name, place) in enumerate(people.items()):
        pose = Pose2D(2.0, 2.0 + 2.0 * number)
        seen = [] if place is None else [Point(place[0] - pose.x, place[1] - pose.y)]
        found = [PositionMeasurement(Header(), f"{name}/1", "1", point, 0.9) for point in seen]
        header = Header(stamp=Time.of(NOW), frame_id="map")
        robots.take(read_report(PeopleReport(header, name, PoseWithCovariance(Pose.of(pose)), found)), NOW)
    known = robots.known
    sightings = observe(table, list(known.values()), NOW, CoordinatorParameters())
    for owner, row in zip(sightings.owners.tolist(), sightings.people.tolist(), strict=True):
        name = sightings.robots[owner].name
        table.rows[row].seen_by[name] = f"{name}/1"
    for turn in range(20):
        views = [
            view_of(k, known[name].pose, AROUND) for k, name in enumerate(sorted(known)) if known[name].trust.trusted
        ]
        RobotComparison(table, known, views, walls, bodies=np.zeros((0, 2)), radius=0.25).judge(turn, 1.0)
    return {name: robot.trust.reason for name, robot in known.items()}


def test_a_robot_whose_person_two_others_should_see_and_do_not_is_not_trusted() -> None:
    assert reasons(HALL, a=(4.0, 4.0), b=None, c=None) == {"a": ALONE, "b": "", "c": ""}


def test_robots_that_see_the_same_person_are_trusted() -> None:
    assert reasons(HALL, a=(4.0, 4.0), b=(4.0, 4.0), c=None) == {"a": "", "b": "", "c": ""}


def test_a_robot_that_sees_somebody_behind_a_wall_is_not_trusted() -> None:
    assert reasons(DIVIDED, a=(10.0, 4.0), b=None) == {"a": WALLS, "b": ""}


def test_nobody_denies_a_person_behind_a_wall() -> None:
    assert reasons(DIVIDED, a=(5.0, 4.0), b=None, c=None)["a"] == ALONE
    assert ALONE not in reasons(DIVIDED, a=(10.0, 4.0), b=None, c=None).values()
