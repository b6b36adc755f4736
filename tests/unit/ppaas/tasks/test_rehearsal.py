"""A rehearsal leads simulated robots by the dispatcher itself, and shows when each task would end."""

import math
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.energy.battery import Battery
from ppaas.energy.sites import Sites
from ppaas.tasks.options import After, PlaceHold, Repeat
from ppaas.tasks.orders import RobotNow
from ppaas.tasks.reach import SPEED, straight
from ppaas.tasks.records import Place, Task
from ppaas.tasks.rehearsal import Rehearsal
from tests.support.budget import examples

A, B, C = (0.0, 0.0, 0.0), (10.0, 0.0, 0.0), (20.0, 0.0, 0.0)


def task(name: str = "t", *places: Place, kind: str = "go_to", **fields: Any) -> Task:
    return Task(id=name, kind=kind, places=places or (B,), **fields)  # type: ignore[arg-type]


def rehearsed(*tasks: Task, until: float = math.inf, **robots: Place) -> dict[str, Task]:
    rehearsal = Rehearsal(tasks, {name: RobotNow(place) for name, place in robots.items()}, straight, 0.0)
    rehearsal.run(until)
    return rehearsal.tasks


def test_times_are_those_of_the_ways_and_the_holds() -> None:
    [done] = rehearsed(task("t", B, C, kind="pick_drop", holds=(PlaceHold(seconds=5.0), None)), r=A).values()
    assert (done.state, done.robot) == ("done", "r")
    assert (done.assigned, done.begun, done.ended) == pytest.approx((0.0, 10.0 / SPEED, 25.0 + 10.0 / SPEED))


def test_tasks_wait_for_robots_start_times_and_others() -> None:
    found = rehearsed(task("a"), task("b", C, after=(After(task="a"),)), task("c", A, not_before=300.0), r=A)
    assert [found[name].ended for name in "abc"] == pytest.approx([20.0, 40.0, 300.0 + 40.0])


def test_a_confirmation_comes_after_a_while() -> None:
    rehearsal = Rehearsal(
        [task(holds=(PlaceHold(confirm=True),))], {"r": RobotNow(B)}, straight, 0.0, confirmed_after=7.0
    )
    rehearsal.run(100.0)
    assert rehearsal.tasks["t"].ended == 7.0


def test_a_missed_deadline_and_a_way_that_does_not_exist_are_found() -> None:
    found = rehearsed(task("a", C, priority=90), task("late", A, deadline=5.0), r=A)
    assert (found["late"].state, "deadline" in found["late"].reason) == ("failed", True)
    wall = Rehearsal([task("t", B, C, kind="pick_drop")], {"r": RobotNow(A)}, _wall, 0.0)
    wall.run(math.inf)
    assert (wall.tasks["t"].state, "no way" in wall.tasks["t"].reason) == ("failed", True)


def _wall(start: Place, goal: Place) -> float:
    return straight(start, goal) if (start[0] < 15.0) == (goal[0] < 15.0) else math.inf


def test_repeats_end_with_the_time_of_the_rehearsal() -> None:
    found = rehearsed(task(repeat=Repeat(every=100.0)), until=350.0, r=A)
    assert sorted(name for name, one in found.items() if one.state == "done") == ["t", "t-2", "t-3", "t-4"]


def test_a_robot_that_is_called_back_on_its_way_has_driven_there_and_back() -> None:
    def around(start: Place, goal: Place) -> float:
        return 0.0 if start == goal else 100.0  # whatever the straight line is

    urgent = task("u", A, priority=9, preempts=True, not_before=50.0)
    rehearsal = Rehearsal([task("t", B), urgent], {"r": RobotNow(A)}, around, 0.0)
    rehearsal.run(math.inf)
    assert rehearsal.tasks["u"].ended == pytest.approx(100.0)
    assert rehearsal.tasks["t"].ended == pytest.approx(100.0 + 100.0 / SPEED)


places = st.tuples(st.integers(0, 40), st.integers(0, 40), st.just(0)).map(lambda xyz: tuple(map(float, xyz)))


@given(st.lists(st.tuples(places, places), min_size=1, max_size=8), st.lists(places, min_size=1, max_size=3))
@settings(max_examples=examples(30), deadline=None)
def test_every_task_ends_and_takes_no_less_than_its_ways(pairs: list[tuple[Place, Place]], starts: list[Place]) -> None:
    tasks = [task(f"t{number}", *pair, kind="pick_drop") for number, pair in enumerate(pairs)]
    found = rehearsed(*tasks, **{f"r{number}": place for number, place in enumerate(starts)})
    for one in found.values():
        assert one.state == "done" and one.begun is not None and one.ended is not None
        assert one.ended - one.begun == pytest.approx(straight(*one.places) / SPEED)
    driven = sum(straight(*pair) for pair in pairs) / SPEED
    assert max(one.ended or 0.0 for one in found.values()) >= driven / len(starts) - 1e-6


def test_a_robot_that_charges_at_the_beginning_goes_on() -> None:
    sites, battery = Sites({"dock": A}), Battery(0.5, 1e-4, 1e-5, 1e-3)
    trip = Task(
        id="c", kind="go_to", places=(A,), holds=(PlaceHold(charge=0.95),), trip="charge", state="active", robot="r",
        named_robot="r", holding=0.0, begun=0.0,
    )  # fmt: skip
    rehearsal = Rehearsal([trip], {"r": RobotNow(A, battery=battery)}, straight, 0.0, sites=sites)
    rehearsal.run(200.0)
    known = rehearsal.batteries["r"]
    assert known is not None and known.charge == pytest.approx(0.7, abs=0.01)
    rehearsal.run(600.0)
    assert rehearsal.tasks["c"].state == "done"
