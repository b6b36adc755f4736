"""Holds, chains, repeats, start times, named robots, weights and preemption, as a dispatcher leads them."""

from typing import Any

import pytest
from msgspec.structs import replace

from ppaas.tasks.dispatcher import GONE_AFTER, Dispatcher
from ppaas.tasks.options import After, PlaceHold, Repeat
from ppaas.tasks.orders import Order, RobotNow, Send, StoreTask
from ppaas.tasks.records import Place, Task

A, B, C = (0.0, 0.0, 0.0), (10.0, 0.0, 0.0), (20.0, 0.0, 0.0)


def task(name: str = "t", *places: Place, kind: str = "go_to", **fields: Any) -> Task:
    return Task(id=name, kind=kind, places=places or (B,), **fields)  # type: ignore[arg-type]


def begun(*tasks: Task, **robots: Place) -> Dispatcher:
    dispatcher = Dispatcher(tasks, 0.0)
    dispatcher.see({name: RobotNow(place) for name, place in robots.items()}, 0.0)
    dispatcher.decide(0.0)
    return dispatcher


def sent(orders: list[Order]) -> list[tuple[str, str]]:
    return [(order.robot, order.goal_id) for order in orders if isinstance(order, Send)]


def stored(orders: list[Order]) -> list[Task]:
    return [order.task for order in orders if isinstance(order, StoreTask)]


def arrive(dispatcher: Dispatcher, now: float = 1.0) -> list[Order]:
    [one] = [task for task in dispatcher.tasks.values() if task.robot]
    return dispatcher.goal_ended(one.robot, one.goal_id, "succeeded", "", now)


# -- holds -------------------------------------------------------------------------------------------------------------


def confirmed(dispatcher: Dispatcher, name: str = "t") -> None:
    known = dispatcher.tasks[name]
    dispatcher.confirm(replace(known, confirmed=known.leg))


def test_a_robot_holds_until_it_is_confirmed() -> None:
    dispatcher = begun(task("t", B, C, kind="pick_drop", holds=(PlaceHold(confirm=True), None)), r=A)
    [holds] = stored(arrive(dispatcher, 5.0))
    assert (holds.state, holds.leg, holds.holding, holds.is_loaded) == ("active", 0, 5.0, True)
    assert dispatcher.release(1000.0) == []
    assert dispatcher.goal_ended("r", "task-t-0-0", "succeeded", "", 6.0) == []
    confirmed(dispatcher)
    orders = dispatcher.release(1001.0)
    assert sent(orders) == [("r", "task-t-1-0")]
    assert stored(orders)[0].holding is None
    [done] = stored(arrive(dispatcher, 1010.0))
    assert (done.state, done.ended) == ("done", 1010.0)


def test_a_hold_with_a_time_ends_by_itself_and_a_confirmation_ends_it_earlier() -> None:
    dispatcher = begun(task(holds=(PlaceHold(confirm=True, seconds=30.0),)), r=A)
    arrive(dispatcher, 5.0)
    assert dispatcher.release(34.9) == []
    [done] = stored(dispatcher.release(35.0))
    assert done.state == "done"
    early = begun(task(holds=(PlaceHold(confirm=True, seconds=30.0),)), r=A)
    arrive(early, 5.0)
    confirmed(early)
    assert [one.state for one in stored(early.release(6.0))] == ["done"]


def test_a_hold_for_a_time_is_not_confirmed() -> None:
    dispatcher = begun(task(holds=(PlaceHold(seconds=30.0),)), r=A)
    arrive(dispatcher, 5.0)
    confirmed(dispatcher)
    assert dispatcher.release(6.0) == []


def test_each_round_of_a_patrol_is_confirmed_again() -> None:
    dispatcher = begun(task("t", A, B, kind="patrol", rounds=2, holds=(PlaceHold(confirm=True), None)), r=A)
    goals = []
    for _ in range(2):
        arrive(dispatcher)
        assert dispatcher.release(2.0) == []
        confirmed(dispatcher)
        goals += sent(dispatcher.release(3.0)) + sent(arrive(dispatcher))
    assert goals == [("r", "task-t-1-0"), ("r", "task-t-2-0"), ("r", "task-t-3-0")]
    assert not dispatcher.tasks


def test_a_dispatcher_after_a_restart_does_not_send_a_robot_away_that_holds() -> None:
    dispatcher = begun(task("t", B, C, kind="patrol", holds=(PlaceHold(confirm=True), None)), r=A)
    arrive(dispatcher)
    again = Dispatcher(dispatcher.tasks.values(), 100.0)
    assert again.see({"r": RobotNow(B)}, 100.0) == []
    confirmed(again)
    assert sent(again.release(101.0)) == [("r", "task-t-1-0")]


def test_a_robot_that_is_lost_while_it_holds_gives_its_task_back_and_the_next_one_holds_again() -> None:
    dispatcher = begun(task("t", B, C, kind="patrol", holds=(PlaceHold(confirm=True), None)), r=A)
    arrive(dispatcher)
    confirmed(dispatcher)
    [back] = stored(dispatcher.see({}, GONE_AFTER + 2.0))
    assert (back.state, back.holding, back.confirmed, back.leg) == ("queued", None, None, 0)
    dispatcher.see({"s": RobotNow(A)}, 100.0)
    dispatcher.decide(100.0)
    arrive(dispatcher, 101.0)
    assert dispatcher.release(102.0) == []


# -- when and by whom --------------------------------------------------------------------------------------------------


def test_a_task_begins_not_before_its_time() -> None:
    dispatcher = begun(task(not_before=50.0), r=A)
    assert dispatcher.decide(49.0) == []
    assert sent(dispatcher.decide(50.0)) == [("r", "task-t-0-0")]


def test_a_named_robot_alone_does_its_task() -> None:
    dispatcher = begun(task(named_robot="far"), near=B, far=C)
    assert dispatcher.tasks["t"].robot == "far"


@pytest.mark.parametrize(
    ("payload", "does"), [("20", True), ("20.5", True), ("19", False), ("nan", False), ("x", False)]
)
def test_a_robot_loads_no_more_than_its_payload(payload: str, does: bool) -> None:
    dispatcher = Dispatcher([task(weight=20.0)], 0.0)
    dispatcher.see({"r": RobotNow(A, {"payload": payload}), "s": RobotNow(B)}, 0.0)
    dispatcher.decide(0.0)
    assert dispatcher.tasks["t"].robot == ("r" if does else "")


# -- chains ------------------------------------------------------------------------------------------------------------


def test_a_task_begins_after_another_is_done() -> None:
    dispatcher = begun(task("a"), task("b", C, after=(After(task="a"),)), r=A, s=C)
    assert dispatcher.tasks["b"].state == "queued"
    arrive(dispatcher)
    assert sent(dispatcher.decide(2.0)) == [("s", "task-b-0-0")]


def test_a_task_whose_condition_fails_is_cancelled_and_with_it_those_that_wait_for_it() -> None:
    tasks = [task("a"), task("b", after=(After(task="a", on="failed"),)), task("c", after=(After(task="b"),))]
    dispatcher = begun(*tasks, r=A)
    arrive(dispatcher)
    ended = stored(dispatcher.decide(2.0))
    assert [(one.id, one.state) for one in ended] == [("b", "cancelled"), ("c", "cancelled")]
    assert "'a' is done" in ended[0].reason


def test_a_dispatcher_after_a_restart_knows_how_tasks_have_ended() -> None:
    dispatcher = begun(task("a", state="failed"), task("b", after=(After(task="a", on="failed"),)), r=A)
    assert dispatcher.tasks["b"].robot == "r"


# -- repeats -----------------------------------------------------------------------------------------------------------


def test_a_task_that_repeats_waits_again_before_its_end_is_stored() -> None:
    dispatcher = begun(task(repeat=Repeat(every=60.0, count=2)), r=A)
    again, done = stored(arrive(dispatcher, 20.0))
    assert (again.id, again.state, again.not_before) == ("t-2", "queued", 60.0)
    assert (done.id, done.state) == ("t", "done")
    assert dispatcher.decide(59.0) == []
    assert sent(dispatcher.decide(60.0)) == [("r", "task-t-2-0-0")]
    assert [one.id for one in stored(arrive(dispatcher, 70.0))] == ["t-2"]


def test_a_dispatcher_that_was_killed_between_both_records_stores_the_next_run_once() -> None:
    first = begun(task(repeat=Repeat(every=60.0)), r=A)
    again, _ = stored(arrive(first, 20.0))
    [assigned] = begun(task(repeat=Repeat(every=60.0)), r=A).tasks.values()
    dispatcher = Dispatcher([assigned, again], 30.0)
    dispatcher.see({"r": RobotNow(B)}, 30.0)
    assert [one.id for one in stored(dispatcher.goal_ended("r", "task-t-0-0", "succeeded", "", 31.0))] == ["t"]


def test_a_task_that_fails_repeats_and_a_cancelled_one_does_not() -> None:
    dispatcher = Dispatcher([task(deadline=5.0, repeat=Repeat(every=60.0))], 0.0)
    again, failed = stored(dispatcher.decide(6.0))
    assert (again.id, again.deadline, failed.state) == ("t-2", 65.0, "failed")
    dispatcher.withdraw("t-2")
    assert not dispatcher.tasks


# -- preemption --------------------------------------------------------------------------------------------------------


def patrol(**fields: Any) -> Dispatcher:
    dispatcher = begun(task("p", A, B, kind="patrol", rounds=9, **fields), r=A)
    arrive(dispatcher)
    return dispatcher


def test_a_task_that_preempts_takes_the_robot_of_a_lower_one_that_goes_on_later() -> None:
    dispatcher = patrol()
    dispatcher.add(task("u", C, priority=5, preempts=True), 2.0)
    orders = dispatcher.decide(2.0)
    assert sent(orders) == [("r", "task-u-0-0")]
    [back, given] = stored(orders)
    assert (back.id, back.state, back.leg, back.failures) == ("p", "queued", 1, 0)
    assert "'u'" in back.reason
    assert given.robot == "r"
    assert dispatcher.goal_ended("r", "task-p-1-0", "canceled", "", 3.0) == []
    dispatcher.goal_ended("r", "task-u-0-0", "succeeded", "", 9.0)
    assert sent(dispatcher.decide(9.0)) == [("r", "task-p-1-1")]


@pytest.mark.parametrize(
    "urgent",
    [
        {"priority": 5},
        {"priority": 5, "preempts": True, "weight": 1.0},
        {"preempts": True},
        {"priority": 5, "preempts": True, "not_before": 9.0},
    ],
    ids=str,
)
def test_a_task_does_not_preempt_without_the_right_to_it(urgent: dict[str, Any]) -> None:
    dispatcher = patrol()
    dispatcher.add(task("u", C, **urgent), 2.0)
    assert dispatcher.decide(2.0) == []


def test_what_was_picked_is_not_preempted() -> None:
    dispatcher = begun(task("p", A, B, kind="pick_drop"), r=A)
    arrive(dispatcher)
    dispatcher.add(task("u", C, priority=50, preempts=True), 2.0)
    assert dispatcher.decide(2.0) == []


def test_a_free_robot_goes_before_one_is_preempted() -> None:
    dispatcher = patrol()
    dispatcher.add(task("u", C, priority=5, preempts=True), 2.0)
    dispatcher.see({"r": RobotNow(C), "free": RobotNow(A)}, 2.0)
    assert sent(dispatcher.decide(2.0)) == [("free", "task-u-0-0")]
    assert dispatcher.tasks["p"].robot == "r"
