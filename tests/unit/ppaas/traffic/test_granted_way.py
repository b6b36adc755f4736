"""The granted way: what a robot takes, reaches, gives back, and when it has left it."""

import math

import pytest

from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.fleet.traffic import MapPoint, TrafficGrants
from ppaas.traffic.granted_way import GrantedWay, path_along

START = Pose2D(0.0, 0.0)


def grants(
    number: int, *points: tuple[float, float], first: int = 0, epoch: int = 1, **fields: object
) -> TrafficGrants:
    """Return grants of some cells, 1 m apart."""
    way = [MapPoint(*point) for point in points]
    return TrafficGrants(Header(), "tb1", epoch, number, 0, 1.0, first, way, **fields)  # type: ignore[arg-type]


def way_of(*points: tuple[float, float]) -> GrantedWay:
    """Return a way with some points, at the first of which the robot stands."""
    way = GrantedWay(0.3)
    way.take(grants(1, *points), START)
    way.advance(START)
    return way


def test_older_grants_and_those_of_an_earlier_epoch_are_ignored() -> None:
    way = GrantedWay(0.3)
    assert way.take(grants(5, (0.0, 0.0)), START)
    assert not way.take(grants(4, (0.0, 0.0), (1.0, 0.0)), START)
    assert way.take(grants(1, (0.0, 0.0), epoch=2), START)
    assert not way.take(grants(9, (0.0, 0.0), (1.0, 0.0)), START)
    assert way.end == 1


def test_grants_of_another_revision_add_nothing() -> None:
    way = way_of((0.0, 0.0), (1.0, 0.0))
    way.give_back(START)
    assert way.take(grants(2, (0.0, 0.0), (1.0, 0.0), (2.0, 0.0)), START)
    assert (way.end, way.ahead, way.held) == (0, 0, [])


def test_grants_with_a_gap_add_nothing() -> None:
    way = way_of((0.0, 0.0))
    way.take(grants(2, (3.0, 0.0), first=3), START)
    assert way.end == 1


def test_grants_that_repeat_what_is_known_add_the_rest() -> None:
    way = way_of((0.0, 0.0), (1.0, 0.0))
    way.take(grants(2, (1.0, 0.0), (2.0, 0.0), first=1), START)
    assert (way.end, way.ahead) == (3, 2)


def test_a_cell_is_held_until_the_next_one_is_reached() -> None:
    way = way_of((0.0, 0.0), (1.0, 0.0), (2.0, 0.0))
    assert not way.advance(Pose2D(0.85, 0.0))
    assert (way.first, [point.x for point in way.held]) == (0, [0.0, 1.0, 2.0])
    assert way.advance(Pose2D(0.95, 0.0))
    assert (way.first, [point.x for point in way.held]) == (1, [1.0, 2.0])


def test_a_robot_that_turns_back_has_not_reached_the_cell_it_came_from() -> None:
    way = way_of((0.0, 0.0), (1.0, 0.0), (0.0, 0.0))
    assert way.ahead == 2
    way.advance(Pose2D(1.0, 0.0))
    assert way.ahead == 1
    way.advance(Pose2D(0.05, 0.0))
    assert way.ahead == 0


@pytest.mark.parametrize(("y", "stray"), [(0.0, False), (0.35, False), (0.45, True), (-0.45, True)])
def test_a_robot_is_stray_beyond_a_part_of_a_cell(y: float, *, stray: bool) -> None:
    way = way_of((0.0, 0.0), (1.0, 0.0))
    assert way.is_stray(Pose2D(0.5, y)) == stray


def test_a_robot_that_drives_freely_is_never_stray() -> None:
    way = GrantedWay(0.3)
    way.take(grants(1, free=True), START)
    assert way.free and not way.is_stray(Pose2D(9.0, 9.0))


def test_a_leg_ends_where_the_robot_drives_back() -> None:
    way = way_of((0.0, 0.0), (1.0, 0.0), (0.0, 0.0))
    leg, ends = way.leg()
    assert ([each.point for each in leg], ends) == ([(0.0, 0.0), (1.0, 0.0)], False)


def test_a_corner_that_is_known_in_time_is_a_curve() -> None:
    leg, ends = way_of((0.0, 0.0), (1.0, 0.0), (1.0, 1.0)).leg()
    assert (leg[1].curved, ends) == (True, True)
    path = path_along(leg, 1.0, START)
    corner = math.dist((1.0, 0.0), min(path[:, :2].tolist(), key=lambda p: math.dist(p, (1.0, 0.0))))
    assert corner == pytest.approx(0.5 * (math.sqrt(2.0) - 1.0), abs=0.01)


def test_a_corner_that_is_learnt_of_late_is_none() -> None:
    way = way_of((0.0, 0.0), (1.0, 0.0))
    way.take(grants(2, (0.0, 0.0), (1.0, 0.0), (1.0, 1.0)), Pose2D(0.8, 0.0))
    leg, ends = way.leg()
    assert ([each.point for each in leg], ends) == ([(0.0, 0.0), (1.0, 0.0)], False)


def test_the_path_begins_beside_the_robot_and_ends_at_the_goal() -> None:
    leg, _ = way_of((0.0, 0.0), (1.0, 0.0), (2.0, 0.0)).leg()
    path = path_along(leg, 1.0, Pose2D(0.62, 0.1), Pose2D(2.05, -0.05, 1.0))
    assert path[0, 0] == pytest.approx(0.6, abs=0.06)
    assert path[-1, :2] == pytest.approx([2.05, -0.05])


def test_a_way_leads_to_the_goal_that_it_was_granted_for() -> None:
    way = GrantedWay(0.3)
    assert not way.leads_to("a")
    way.take(grants(1, (0.0, 0.0), at_goal=True, goal_id="a"), START)
    assert way.leads_to("a") and not way.leads_to("b")
    assert way.last == (0.0, 0.0)
    assert way.stop_near(Pose2D(1.0, -0.03)) == pytest.approx((0.1, -0.03, 0.0))


def test_grants_with_a_cell_twice_in_a_row_are_not_taken() -> None:
    way = way_of((0.0, 0.0))
    assert not way.take(grants(2, (0.0, 0.0), (1.0, 0.0), (1.0, 0.0)), START)
    assert (way.number, way.end) == (1, 1)


# -- spurs -------------------------------------------------------------------------------------------------------------


def on_spur() -> GrantedWay:
    """Return the way of a robot that has taken a spur of 0.4 m from the second cell."""
    way = way_of((0.0, 0.0), (1.0, 0.0))
    assert way.take(grants(2, (0.0, 0.0), (1.0, 0.0), at_goal=True, goal_id="a", spur=[MapPoint(1.0, 0.4)]), START)
    assert way.spur_to == MapPoint(1.0, 0.4)
    way.take_spur(MapPoint(1.0, 0.4))
    return way


def test_a_robot_on_its_spur_has_not_left_its_way() -> None:
    way = on_spur()
    assert not way.is_stray(Pose2D(1.0, 0.4)) and way.off(Pose2D(1.1, 0.2)) == pytest.approx(0.1)
    assert way.advance(Pose2D(1.0, 0.0))
    assert not way.is_stray(Pose2D(1.0, 0.45)) and way.is_stray(Pose2D(1.0, 0.9))
    assert (way.spur, way.is_recalled) == ([MapPoint(1.0, 0.4)], False)


@pytest.mark.parametrize("more", [((0.0, 0.0), (1.0, 0.0)), ((0.0, 0.0), (1.0, 0.0), (2.0, 0.0))])
def test_a_robot_drives_back_from_its_spur_when_it_is_told_to_or_goes_on(more: tuple[tuple[float, float], ...]) -> None:
    way, aside = on_spur(), Pose2D(1.0, 0.4)
    way.advance(Pose2D(1.0, 0.0))
    way.take(grants(3, *more), aside)
    assert way.is_recalled
    leg, ends = way.leg()
    assert ([each.point for each in leg], ends) == ([(1.0, 0.4), (1.0, 0.0)], False)
    assert not way.advance(aside) and way.spur
    assert way.advance(Pose2D(1.0, 0.09)) and not way.spur
    assert way.leg()[1]


def test_a_robot_drives_back_from_its_spur_before_it_takes_another() -> None:
    way, aside = on_spur(), Pose2D(1.0, 0.4)
    way.advance(Pose2D(1.0, 0.0))
    way.take(grants(3, (0.0, 0.0), (1.0, 0.0), at_goal=True, goal_id="b", spur=[MapPoint(1.4, 0.0)]), aside)
    assert way.is_recalled and way.spur == [MapPoint(1.0, 0.4)]
    assert not way.leg()[1], "it ends no goal before it is back"
    assert way.advance(Pose2D(1.0, 0.0)) and way.leg()[1]


def test_a_spur_that_was_not_reached_is_left_at_once() -> None:
    way = on_spur()
    way.take(grants(3, (0.0, 0.0), (1.0, 0.0)), START)
    assert way.advance(START)
    assert (way.spur, way.is_recalled) == ([], False)


def test_no_cell_counts_as_reached_from_a_spur() -> None:
    way = on_spur()
    way.take(grants(3, (0.0, 0.0), (1.0, 0.0), (2.0, 0.0)), START)
    way.advance(Pose2D(1.0, 0.0))
    way = on_spur()
    way.advance(Pose2D(1.0, 0.0))
    way.take(grants(3, (0.0, 0.0), (1.0, 0.0), (2.0, 0.0)), Pose2D(1.0, 0.4))
    assert not way.advance(Pose2D(1.95, 0.2))
    assert way.reached == 2


def test_giving_back_the_way_ends_the_spur() -> None:
    way = on_spur()
    way.give_back(Pose2D(1.0, 0.4))
    assert (way.spur, way.spur_to, way.is_recalled) == ([], None, False)
