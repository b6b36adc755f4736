"""Contradictions between identities: robots that see one of two people should see the other, too."""

import math

import numpy as np

from ppaas.costmap.costmap import LETHAL_OBSTACLE, Costmap
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo
from ppaas.messages.people_coordination import SensorView
from ppaas.people.coordinator.coordinator import Contradictions
from ppaas.people.coordinator.people_table import PeopleTable
from ppaas.people.coordinator.visibility import Walls, view_of

AROUND = SensorView(0.0, 0.0, 0.0, 2.0 * math.pi, 0.0, 8.0)
NARROW = SensorView(0.0, 0.0, 0.0, math.radians(20.0), 0.1, 8.0)


def contradict(
    *people: tuple[float, float], views: tuple[SensorView, SensorView] = (AROUND, AROUND), wall: bool = False
) -> bool:
    """Return whether the first two people contradict: r1 at x = 1 sees the first, r2 at x = 9 the second, y = 4."""
    table = PeopleTable()
    table.begin(np.array(people), np.broadcast_to(0.01 * np.eye(2), (len(people), 2, 2)), 0.0)
    for person in table.rows:
        person.confirmed = True
    table.rows[0].seen_by["r1"], table.rows[1].seen_by["r2"] = "r1/0", "r2/0"
    data = np.zeros((160, 200), np.uint8)
    data[:, 100:102] = LETHAL_OBSTACLE if wall else 0
    walls = Walls(Costmap(data, GridInfo(0.05, 200, 160)))
    poses = Pose2D(1.0, 4.0, 0.0), Pose2D(9.0, 4.0, math.pi)
    both = [view_of(number, pose, view) for number, (pose, view) in enumerate(zip(poses, views, strict=True))]
    (found,) = Contradictions(table, ["r1", "r2"], both, walls, 0.25)([(0, 1)])
    return found


def test_two_people_whom_both_robots_should_see_and_each_sees_one_of_contradict() -> None:
    assert contradict((4.2, 3.0), (5.8, 3.0))


def test_one_robot_that_need_not_see_the_other_person_is_enough_against_it() -> None:
    assert not contradict((4.0, 4.0), (4.0, 6.0), views=(NARROW, AROUND))


def test_a_wall_or_a_third_person_explains_why_both_are_not_seen() -> None:
    assert not contradict((4.2, 3.0), (5.8, 3.0), wall=True)
    assert not contradict((3.0, 4.0), (7.0, 4.0), (5.0, 4.0))


def test_neither_of_the_two_hides_the_other() -> None:
    assert contradict((4.0, 4.0), (6.0, 4.0))
