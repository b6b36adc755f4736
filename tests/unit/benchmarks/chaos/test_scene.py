"""Scenes of a chaos run."""

from benchmarks.chaos import scene
from benchmarks.chaos.scene import in_office, in_traffic
from ppaas.geometry import Pose2D


def test_robots_in_traffic_start_and_end_in_different_cells_and_are_far_from_walls() -> None:
    traffic = in_traffic(1, 5, (18.0, 12.0))
    starts = [course.start for course in traffic.courses]
    assert len(starts) == 5
    assert min(one.distance_to(other) for one in starts for other in starts if one is not other) > 0.5
    assert all(len(set(course.goals)) == scene.GOALS for course in traffic.courses)
    assert traffic.traffic and traffic.contacts == 0


def test_the_contacts_of_a_scene_are_those_of_pairs() -> None:
    traffic = in_traffic(1, 2, (18.0, 12.0))
    x, y, _ = traffic.courses[0].start
    traffic.world.add_robot(Pose2D(x, y))
    traffic.world.add_robot(Pose2D(x + 0.2, y))
    traffic.world.step()
    assert traffic.contacts == 1


def test_robots_in_an_office_are_not_in_traffic() -> None:
    office = in_office(1, 3, 2, 1, (9.0, 10.0))
    assert (office.map_id, len(office.courses), office.operated, office.traffic) == ("chaos-1", 2, 1, False)
