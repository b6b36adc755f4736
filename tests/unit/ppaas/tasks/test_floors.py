"""Places on floors are equal only on the same floor, and cost a ride from each other."""

import pytest

from ppaas.energy.battery import Battery
from ppaas.energy.sites import Sites
from ppaas.errors import InvalidInput
from ppaas.tasks.assignment import TaskRobot, may_do
from ppaas.tasks.chargers import SHUNNED_FOR
from ppaas.tasks.charging import trips
from ppaas.tasks.dispatcher import Dispatcher
from ppaas.tasks.floors import PlaceOnFloor, bare, floor_of, on_floor
from ppaas.tasks.options import Repeat
from ppaas.tasks.orders import RobotNow, Send, StoreTask
from ppaas.tasks.reach import DETOUR, RIDE, SPEED, remaining, straight, way_home
from ppaas.tasks.records import Place, Task, check_task
from ppaas.tasks.rehearsal import Rehearsal
from ppaas.tasks.succession import following
from ppaas.tasks.ways import NO_WAY, ways_by_times, with_way_reasons

A, B = (0.0, 0.0, 0.0), (10.0, 0.0, 0.0)


def up(place: Place) -> Place:
    return on_floor(place, "L2")


def down(place: Place) -> Place:
    return on_floor(place, "L1")


def task(name: str = "t", *places: Place, **fields: object) -> Task:
    given = {"kind": "go_to", "home": "L1"} | fields
    return Task(id=name, places=places or (B,), **given)  # type: ignore[arg-type]


def test_the_same_numbers_on_another_floor_are_another_place() -> None:
    assert up(A) == up(A) and hash(up(A)) == hash(up(A))
    assert up(A) != down(A) and up(A) != A and up(A) != A
    assert not up(A) == A and not up(A) == A  # noqa: SIM201 - tuples have methods for both
    assert len({up(A), down(A), A, up(A)}) == 3
    assert on_floor(A, "") is A
    assert (floor_of(up(A)), floor_of(A)) == ("L2", "")
    assert bare(up(B)) == B and not isinstance(bare(up(B)), PlaceOnFloor)
    assert straight(up(A), down(B)) == pytest.approx(10.0 + RIDE) and straight(up(A), up(B)) == 10.0


def test_the_places_of_a_task_are_on_its_floors_or_on_that_of_its_map() -> None:
    over = task("t", A, B, kind="patrol", floors=("L2", "L1"), leg=1)
    assert (over.stops, over.target) == ((up(A), down(B)), down(B))
    assert task("t", A).target == down(A) and task("t", A, home="").target is A
    assert remaining(over, up(B)) == pytest.approx(RIDE / SPEED)
    with pytest.raises(InvalidInput, match="'floors' must be one a place, 2 in all, or none, not 1"):
        check_task(task("t", A, B, kind="pick_drop", floors=("L1",)))
    again = following(task("t", A, floors=("L2",), state="done", repeat=Repeat(every=60.0)), 0.0)
    assert again is not None and (again.floors, again.home) == (("L2",), "L1")


def test_a_task_without_floors_is_only_for_robots_on_its_map() -> None:
    assert may_do(task(), "r", {}, down(A)) and not may_do(task(), "r", {}, up(A))
    assert may_do(task(floors=("L1",)), "r", {}, up(A)) and may_do(task(), "r", {})
    dispatcher = Dispatcher([task("plain", priority=9, preempts=True), task("over", floors=("L1",))], 0.0)
    dispatcher.see({"r": RobotNow(up(A))}, 0.0)
    sent = [order for order in dispatcher.decide(0.0) if isinstance(order, Send)]
    assert [(order.goal_id, order.over_floors) for order in sent] == [("task-over-0-0", True)]


def test_tasks_to_which_no_way_leads_say_so_until_one_does() -> None:
    robots = [TaskRobot("r", down(A)), TaskRobot("other", up(A))]
    cut = ways_by_times([down(A), up(A)], [up(B)], [[None], [None]])
    tasks = [task("over", floors=("L2",)), task("plain"), task("begun", floors=("L2",), robot="r")]
    [waits] = with_way_reasons(tasks, robots, cut)
    assert (waits.id, waits.reason) == ("over", NO_WAY)
    assert with_way_reasons([waits], robots, cut) == []
    [again] = with_way_reasons([waits], robots, ways_by_times([down(A)], [up(B)], [[20.0]]))
    assert again.reason == ""
    assert with_way_reasons([task("over", floors=("L2",), reason="failed before")], robots, cut) == []


def test_a_robot_charges_at_the_nearest_place_on_floors_that_it_gets_to() -> None:
    low, far = Battery(0.3, 1e-4, 1e-6, 1e-3), (20.0, 0.0, 0.0)
    both = {"L1": {"L1", "L2"}, "L2": {"L1", "L2"}}
    sites = Sites(chargers={"L1/a": down(B), "L2/b": up(far)}, linked=both)
    robots = {"r": RobotNow(up(A), battery=low), "s": RobotNow(down(A), battery=low)}
    found = dict(trips(robots, {}, sites, [], 1.0))
    assert {name: (trip.target, trip.floors, trip.home) for name, trip in found.items()} == {
        "r": (up(far), (), "L2"), "s": (down(B), (), "L1"),
    }  # fmt: skip
    below = Sites(chargers={"L1/a": down(B)}, linked=both)
    [(_, trip)] = trips({"r": robots["r"]}, {}, below, [], 1.0)
    assert (trip.places, trip.floors, trip.home) == ((B,), ("L1",), "L1")
    assert type(trip.places[0]) is tuple
    assert way_home(up(A), below) == pytest.approx(DETOUR * (10.0 + RIDE))
    cut = Sites(chargers={"L1/a": down(B)}, linked={"L1": {"L1"}, "L2": {"L2"}})
    assert trips({"r": robots["r"]}, {}, cut, [], 1.0) == []
    assert (way_home(up(A), cut), way_home(down(A), cut)) == (0.0, pytest.approx(DETOUR * 10.0))


@pytest.mark.parametrize("sites", [Sites(chargers={"a": B}), Sites(parking={"a": B})])
def test_a_robot_whose_trip_has_failed_does_not_go_there_again_for_a_while(sites: Sites) -> None:
    dispatcher = Dispatcher([], 0.0)
    dispatcher.sites = sites
    seen = {"r": RobotNow(A, battery=Battery(0.3, 1e-4, 1e-6, 1e-3))}
    dispatcher.see(seen, 0.0)
    [goal] = [order.goal_id for order in dispatcher.decide(0.0) if isinstance(order, Send)]
    dispatcher.goal_ended("r", goal, "aborted", "no way", 1.0)
    dispatcher.decide(SHUNNED_FOR)
    assert not dispatcher.tasks
    assert [type(order) for order in dispatcher.decide(1.0 + SHUNNED_FOR)] == [StoreTask, Send]


def test_a_rehearsal_leads_robots_over_floors() -> None:
    way = ways_by_times([down(A), up(A)], [up(B), down(B)], [[100.0, 20.0], [20.0, 100.0]])
    over = task("over", B, B, kind="pick_drop", floors=("L2", "L1"))
    rehearsal = Rehearsal([over], {"r": RobotNow(up(A)), "s": RobotNow(down(A))}, way, 0.0)
    rehearsal.run(1e4)
    done = rehearsal.tasks["over"]
    assert (done.state, done.robot) == ("done", "r")
    assert done.ended == pytest.approx(20.0 + RIDE / SPEED)


def test_a_robot_that_rides_keeps_its_task_although_it_is_silent() -> None:
    dispatcher = Dispatcher([task("t", floors=("L2",))], 0.0)
    dispatcher.see({"r": RobotNow(down(A))}, 0.0)
    dispatcher.decide(0.0)
    for now in (20.0, 40.0, 60.0, 80.0):
        assert dispatcher.see({}, now, {"r": 0.0}, {"r"}) == []
    [queued] = [order.task for order in dispatcher.see({}, 120.0, {"r": 0.0}) if isinstance(order, StoreTask)]
    assert queued.state == "queued"


def test_goals_on_the_way_of_a_task_are_its_own() -> None:
    dispatcher = Dispatcher([task("t", floors=("L2",))], 0.0)
    dispatcher.see({"r": RobotNow(down(A))}, 0.0)
    dispatcher.decide(0.0)
    own, stray = frozenset({"task-t-0-0/3"}), frozenset({"task-old-1-0/2", "task-t-0-0/3"})
    assert dispatcher.see({"r": RobotNow(down(A), goals=own)}, 1.0) == []
    assert [order.goal_id for order in dispatcher.see({"r": RobotNow(down(A), goals=stray)}, 2.0)] == ["task-old-1-0"]  # type: ignore[union-attr]
