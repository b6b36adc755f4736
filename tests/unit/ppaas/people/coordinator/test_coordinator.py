"""Coordinator: robots that see people in a hall, one identity for each person, a count and orders to follow."""

import math
from collections.abc import Callable, Sequence

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.people.report_world import AROUND, ReportingRobot, ReportWorld
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.costmap import LETHAL_OBSTACLE, Costmap
from ppaas.errors import InvalidInput, NotFound
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo
from ppaas.messages.geometry_msgs import Point
from ppaas.messages.people_coordination import LOST, PREDICTED, SEEN, PeopleReport, PeopleState, SensorView
from ppaas.people.coordinator.coordinator import Contradictions, PeopleCoordinator
from ppaas.people.coordinator.group import FROZEN
from ppaas.people.coordinator.people_table import PeopleTable
from ppaas.people.coordinator.visibility import Walls, view_of
from ppaas.people.settings import CountingZone, PeopleSettings
from ppaas.people.state_checks import check_state
from tests.support.budget import examples
from tests.support.world.rooms import room

HALL = build_layers(room(16.0, 10.0)).costmap
NOW = 1_700_000_000.0
PERIOD = 0.2

Change = Callable[[PeopleReport], PeopleReport]
Route = Callable[[float], tuple[float, float]]


class Stage:
    """A hall with robots, and people who walk along given routes."""

    def __init__(self, robots: Sequence[ReportingRobot], routes: Sequence[Route], **config: object) -> None:
        self.coordinator = PeopleCoordinator(HALL, PeopleSettings(**config))  # type: ignore[arg-type]
        self.world = ReportWorld(HALL, len(routes), robots, detected=1.0)
        self.routes = list(routes)
        self.now = NOW
        self.changes: dict[str, Change] = {}
        self.silent: set[str] = set()

    def run(self, seconds: float) -> list[PeopleState]:
        """Return the states of some seconds."""
        return [self._step() for _ in range(round(seconds / PERIOD))]

    def _step(self) -> PeopleState:
        self.now += PERIOD
        self.world.people = np.array([route(self.now - NOW) for route in self.routes]).reshape(-1, 2)
        for robot in self.world.robots:
            if robot.name not in self.silent:
                report = self.world.report(robot, self.now)
                change = self.changes.get(robot.name, lambda same: same)
                self.coordinator.report(change(report), self.now)
        return self.coordinator.step(self.now)


def robot(name: str, x: float, y: float, **more: object) -> ReportingRobot:
    return ReportingRobot(name, Pose2D(x, y, 0.0), view=AROUND, **more)  # type: ignore[arg-type]


def stands(x: float, y: float) -> Route:
    return lambda _: (x, y)


def walks(x: float, y: float, vx: float, vy: float, stop: float = math.inf) -> Route:
    return lambda seconds: (x + min(seconds, stop) * vx, y + min(seconds, stop) * vy)


def ids(state: PeopleState) -> set[int]:
    return {person.id for person in state.people if person.state == SEEN}


A, B, C = robot("a", 5.0, 5.0), robot("b", 11.0, 5.0), robot("c", 8.0, 2.0)


def test_a_person_whom_two_robots_see_has_one_identity_and_counts_once() -> None:
    state = Stage([A, B], [stands(8.0, 6.0)]).run(1.0)[-1]
    [person] = state.people
    assert (state.count, person.state, person.seen_by) == (1, SEEN, ["a/0", "b/0"])
    assert math.hypot(person.position.x - 8.0, person.position.y - 6.0) < 0.1


def test_the_count_is_of_the_people_in_view_and_falls_when_one_leaves() -> None:
    stage = Stage([A], [stands(6.0, 7.0), walks(9.0, 3.0, 1.5, 0.0)])
    assert stage.run(1.0)[-1].count == 2
    assert stage.run(6.0)[-1].count == 1


def test_two_who_cross_keep_their_identities() -> None:
    stage = Stage([A, B], [walks(4.0, 6.0, 1.0, 0.0), walks(12.0, 6.4, -1.0, 0.0)])
    begun = {person.id: person.velocity.x > 0.0 for person in stage.run(2.0)[-1].people}
    ended = {person.id: person.velocity.x > 0.0 for person in stage.run(4.0)[-1].people}
    assert begun == ended


def test_a_person_behind_another_is_predicted_and_stays_the_same() -> None:
    stage = Stage([A], [walks(8.0, 3.0, 0.0, 1.0), stands(6.5, 5.0)])
    first = ids(stage.run(1.0)[-1])
    states = stage.run(3.0)
    assert any(person.state == PREDICTED for state in states for person in state.people)
    assert ids(states[-1]) == first


def test_a_person_who_should_be_seen_and_is_not_has_left() -> None:
    stage = Stage([A], [stands(8.0, 5.0)])
    stage.run(1.0)
    stage.routes[0] = stands(1000.0, 1000.0)
    state = stage.run(3.0)[-1]
    assert state.count == 0
    assert [person.state for person in state.people] == [LOST]


def test_the_cheapest_robot_follows() -> None:
    [order] = Stage([A, B], [stands(9.0, 5.0)]).run(1.0)[-1].orders
    assert (order.robot, order.person) == ("b", 1)
    assert order.cost > 0.0 and order.reason


def test_another_robot_takes_over_when_the_person_walks_up_to_it() -> None:
    stage = Stage([A, B], [walks(6.0, 5.8, 0.8, 0.0, stop=6.0)])
    orders = [order for state in stage.run(12.0) for order in state.orders]
    robots = [order.robot for order in orders]
    assert robots == sorted(robots) and set(robots) == {"a", "b"}
    assert "falling" in orders[-1].reason


def test_no_robot_takes_over_while_its_cost_does_not_fall() -> None:
    stage = Stage([A, B], [stands(7.6, 5.8)])
    assert {order.robot for state in stage.run(3.0) for order in state.orders} == {"a"}
    stage.world.robots[0] = robot("a", 2.0, 5.0)
    assert {order.robot for state in stage.run(9.0) for order in state.orders} == {"a"}


def test_a_robot_that_leaves_hands_over() -> None:
    stage = Stage([A, B], [stands(7.0, 6.0)])
    stage.run(1.0)
    stage.silent.add("a")
    [order] = stage.run(7.0)[-1].orders
    assert order.robot == "b"


def test_a_robot_that_gave_a_person_up_does_not_get_the_same_person_at_once() -> None:
    stage = Stage([A], [stands(7.0, 6.0)])
    stage.changes["a"] = lambda report: msgspec.structs.replace(report, following=1)
    stage.run(1.0)
    stage.changes["a"] = lambda report: msgspec.structs.replace(report, following=0)
    assert stage.run(4.0)[-1].orders == []
    assert stage.run(8.0)[-1].orders != []


def test_a_named_person_is_followed_by_the_rule_named() -> None:
    stage = Stage([A, B], [stands(6.0, 6.0), stands(9.0, 7.0)])
    far = next(person.id for person in stage.run(1.0)[-1].people if person.position.x > 8.0)
    stage.coordinator.configure(PeopleSettings(rule="named", targets=[far], names={str(far): "Ann"}))
    state = stage.run(1.0)[-1]
    assert [(order.person, order.robot) for order in state.orders] == [(far, "b")]
    assert "Ann" in {person.name for person in state.people} and "Ann" in state.orders[0].reason


def test_several_people_are_followed_by_several_robots() -> None:
    state = Stage([A, B], [stands(6.0, 6.0), stands(10.0, 6.0)], followed_at_once=2).run(1.0)[-1]
    where = {person.id: person.position.x for person in state.people}
    assert {order.robot: round(where[order.person]) for order in state.orders} == {"a": 6, "b": 10}


def test_an_unknown_rule_is_refused_and_the_settings_stay() -> None:
    coordinator = PeopleCoordinator(HALL)
    with pytest.raises(NotFound, match="nearest"):
        coordinator.configure(PeopleSettings(rule="loudest"))
    assert coordinator.step(NOW).rule == "nearest"


def test_two_who_stand_together_are_a_group_and_a_passer_by_is_not() -> None:
    state = Stage([A], [stands(7.0, 6.0), stands(7.9, 5.3), walks(3.0, 8.0, 1.0, 0.0)]).run(4.4)[-1]
    groups = {person.group for person in state.people if person.position.y < 7.0}
    assert (len(groups), 0 in groups) == (1, False)
    assert {person.group for person in state.people if person.position.y > 7.0} == {0}


# -- bad input ---------------------------------------------------------------------------------------------------------


def test_robots_that_disagree_by_a_metre_see_one_person_and_their_deviation_grows() -> None:
    wrong = robot("b", 11.0, 5.0, error=Pose2D(0.6, 0.8, 0.0))
    stage = Stage([A, wrong, C], [walks(6.5, 6.0, 0.5, 0.0, stop=8.0), stands(8.0, 7.0)])
    states = stage.run(8.0)
    assert states[-1].count == 2
    assert sum(state.count == 2 for state in states[10:]) > 0.9 * len(states[10:])
    deviations = {each.robot: each.deviation for each in states[-1].robots}
    assert deviations["b"] > 0.7 > deviations["a"]


def test_a_robot_that_contradicts_all_others_is_not_trusted_and_the_reason_is_told() -> None:
    stage = Stage([A, B, C], [stands(8.0, 7.0)])

    def lie(report: PeopleReport) -> PeopleReport:
        [torso] = report.people
        return msgspec.structs.replace(report, people=[msgspec.structs.replace(torso, pos=Point(-1.5, -1.5))])

    stage.changes["b"] = lie
    state = stage.run(12.0)[-1]
    assert state.count == 1
    [liar] = [each for each in state.robots if not each.trusted]
    assert (liar.robot, liar.reason[:11]) == ("b", "sees people")
    stage.changes.clear()
    assert all(each.trusted for each in stage.run(20.0)[-1].robots)


def test_a_robot_that_sees_people_behind_walls_is_not_trusted() -> None:
    stage = Stage([A], [])
    away = Point(30.0, 0.0)
    seen = Stage([A], [stands(6.0, 6.0)]).world.report(A, NOW).people

    def behind(report: PeopleReport) -> PeopleReport:
        return msgspec.structs.replace(report, people=[msgspec.structs.replace(each, pos=away) for each in seen])

    stage.changes["a"] = behind
    assert "behind walls" in stage.run(25.0)[-1].robots[0].reason


def test_people_in_mirrors_outside_the_map_are_left_out_and_the_others_count() -> None:
    stage = Stage([A], [stands(6.0, 6.0)])

    def reflect(report: PeopleReport) -> PeopleReport:
        ghosts = [
            msgspec.structs.replace(each, object_id=f"{each.object_id}0", name="", pos=Point(30.0, 0.0))
            for each in report.people
        ]
        return msgspec.structs.replace(report, people=[*report.people, *ghosts])

    stage.changes["a"] = reflect
    state = stage.run(6.0)[-1]
    assert (state.count, len(state.people)) == (1, 1)
    assert state.robots[0].trusted


def test_a_report_that_is_not_finite_is_refused_and_changes_nothing() -> None:
    stage = Stage([A], [stands(7.0, 6.0)])
    before = stage.run(1.0)[-1]
    report = stage.world.report(A, stage.now)
    people = [msgspec.structs.replace(report.people[0], pos=Point(math.nan, 0.0))]
    with pytest.raises(InvalidInput, match="finite"):
        stage.coordinator.report(msgspec.structs.replace(report, people=people), stage.now)
    assert ids(stage.run(0.2)[-1]) == ids(before)


@given(st.lists(st.floats(-1.7e308, 1.7e308), min_size=4, max_size=4))
@settings(max_examples=examples(12), deadline=None)
def test_whatever_finite_numbers_a_report_has_the_state_is_finite(numbers: list[float]) -> None:
    def huge(report: PeopleReport) -> PeopleReport:
        covariance = [numbers[0]] * 36
        covariance[0] = covariance[7] = covariance[35] = abs(numbers[0])
        pose = msgspec.structs.replace(report.pose, covariance=covariance)
        spread = [abs(numbers[1]), numbers[2], 0.0, numbers[3], abs(numbers[1]), *[0.0] * 4]
        people = [msgspec.structs.replace(person, covariance=spread) for person in report.people]
        return msgspec.structs.replace(report, pose=pose, people=people)

    stage = Stage([A, B], [stands(8.0, 6.0), walks(7.0, 4.0, 0.5, 0.0)])
    stage.changes["b"] = huge
    for state in stage.run(1.0):
        check_state(state)


def test_an_id_that_is_used_again_for_somebody_else_is_another_person() -> None:
    stage = Stage([A], [stands(4.0, 3.0)])
    first = ids(stage.run(1.0)[-1])
    stage.routes[0] = stands(8.0, 7.0)
    assert ids(stage.run(0.4)[-1]) - first


def test_clocks_half_a_second_apart_do_not_split_a_person() -> None:
    ahead, behind = robot("a", 5.0, 5.0, clock=0.5), robot("b", 11.0, 5.0, clock=-0.5)
    states = Stage([ahead, behind], [walks(5.0, 6.0, 1.2, 0.0, stop=5.0)]).run(5.0)
    assert {state.count for state in states[3:]} == {1}
    assert {person.id for state in states for person in state.people} == {1}


def test_a_robot_that_freezes_is_named_and_its_people_are_not_counted_for_ever() -> None:
    stage = Stage([A], [stands(7.0, 6.0)])
    stage.run(1.0)
    frozen = stage.world.report(A, stage.now)
    stage.changes["a"] = lambda _: frozen
    states = stage.run(40.0)[5:]
    assert {state.count for state in states} == {0}
    assert {(state.robots[0].trusted, state.robots[0].reason) for state in states} == {(False, FROZEN)}


def test_a_group_without_robots_has_no_people() -> None:
    state = PeopleCoordinator(HALL).step(NOW)
    assert (state.count, state.people, state.orders, state.robots) == (0, [], [], [])


def test_a_clock_that_is_set_back_does_not_stop_the_cycle() -> None:
    stage = Stage([A], [stands(7.0, 6.0)])
    stage.run(1.0)
    stage.now -= 100.0
    assert stage.run(1.0)[-1].count == 1


def test_a_robot_that_left_while_the_clock_was_set_back_is_forgotten_as_soon_as_ever() -> None:
    stage = Stage([A], [stands(7.0, 6.0)])
    assert stage.run(2.0)[-1].orders
    stage.now -= 3600.0
    stage.silent = {"a"}
    late = stage.run(2.0)[-1]
    assert (late.count, late.people[0].state) == (0, PREDICTED)
    gone = stage.run(6.0)[-1]
    assert (gone.people[0].state, gone.orders) == (LOST, [])


# -- history and checkpoints -------------------------------------------------------------------------------------------


def test_people_are_counted_once_per_hour_and_zone() -> None:
    zone = CountingZone("door", [(6.0, 5.0), (8.0, 5.0), (8.0, 7.0), (6.0, 7.0)])
    stage = Stage([A], [stands(7.0, 6.0), stands(9.0, 3.0)], zones=[zone], history=True)
    stage.run(1.0)
    assert {count.zone: count.people for count in stage.coordinator.counts(0)} == {"": 2, "door": 1}


def test_nothing_is_counted_without_history() -> None:
    stage = Stage([A], [stands(7.0, 6.0)])
    stage.run(1.0)
    assert stage.coordinator.counts(0) == []


def test_another_coordinator_goes_on_from_a_checkpoint() -> None:
    stage = Stage([A, B], [walks(4.0, 6.0, 0.5, 0.0), stands(9.0, 7.0)], history=True)
    before = stage.run(2.0)[-1]
    saved, other = stage.coordinator.checkpoint(), PeopleCoordinator(HALL, stage.coordinator.settings)
    other.restore(saved)
    stage.coordinator = other
    after = stage.run(1.0)[-1]
    assert ids(after) == ids(before)
    assert [(each.robot, each.person, each.since) for each in after.orders] == [
        (each.robot, each.person, each.since) for each in before.orders
    ]
    assert {count.zone: count.people for count in other.counts(0)} == {"": 2}


@given(st.binary(max_size=200))
def test_bytes_that_are_not_a_checkpoint_are_refused(saved: bytes) -> None:
    with pytest.raises(InvalidInput, match="checkpoint"):
        PeopleCoordinator(HALL).restore(saved)


def test_a_checkpoint_that_is_cut_is_refused() -> None:
    stage = Stage([A], [stands(7.0, 6.0)])
    stage.run(0.6)
    with pytest.raises(InvalidInput):
        stage.coordinator.restore(stage.coordinator.checkpoint()[:-5])


# -- properties --------------------------------------------------------------------------------------------------------


@settings(max_examples=examples(4), deadline=None)
@given(st.permutations([A, B, C]), st.integers(0, 3))
def test_identities_do_not_depend_on_the_order_of_robots_and_reports(order: list[ReportingRobot], seed: int) -> None:
    def run(robots: Sequence[ReportingRobot]) -> list[tuple[int, list[int]]]:
        world, coordinator = ReportWorld(HALL, 6, [A, B, C], seed), PeopleCoordinator(HALL)
        states = []
        for step in range(8):
            world.advance(PERIOD)
            reports = {each.name: world.report(each, NOW + step * PERIOD) for each in world.robots}
            for each in robots:
                coordinator.report(reports[each.name], NOW + step * PERIOD)
            state = coordinator.step(NOW + step * PERIOD)
            states.append((state.count, [person.id for person in state.people]))
        return states

    assert run(order) == run([A, B, C])


@settings(max_examples=examples(4), deadline=None)
@given(st.integers(0, 1000))
def test_the_count_never_exceeds_the_torsos_that_robots_report(seed: int) -> None:
    world, coordinator = ReportWorld(HALL, 6, [A, B], seed, detected=1.0), PeopleCoordinator(HALL)
    for step in range(10):
        world.advance(PERIOD)
        reports = [world.report(each, NOW + step * PERIOD) for each in world.robots]
        for report in reports:
            coordinator.report(report, NOW + step * PERIOD)
        state = coordinator.step(NOW + step * PERIOD)
        held = sum(person.state == SEEN and not person.seen_by for person in state.people)
        assert state.count - held <= sum(len(report.people) for report in reports)
        assert state.count >= max(len(report.people) for report in reports) - 3


def test_a_checkpoint_whose_text_is_not_utf_8_is_refused() -> None:
    with pytest.raises(InvalidInput, match="not a checkpoint of a people coordinator"):
        PeopleCoordinator(HALL).restore(b"\x81\xa4abc\x80\x00")


ALL_AROUND = SensorView(0.0, 0.0, 0.0, 2.0 * math.pi, 0.0, 8.0)
NARROW = SensorView(0.0, 0.0, 0.0, math.radians(20.0), 0.1, 8.0)


def contradict(
    *people: tuple[float, float], views: tuple[SensorView, SensorView] = (ALL_AROUND, ALL_AROUND), wall: bool = False
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
    assert not contradict((4.0, 4.0), (4.0, 6.0), views=(NARROW, ALL_AROUND))


def test_a_wall_or_a_third_person_explains_why_both_are_not_seen() -> None:
    assert not contradict((4.2, 3.0), (5.8, 3.0), wall=True)
    assert not contradict((3.0, 4.0), (7.0, 4.0), (5.0, 4.0))


def test_neither_of_the_two_hides_the_other() -> None:
    assert contradict((4.0, 4.0), (6.0, 4.0))
