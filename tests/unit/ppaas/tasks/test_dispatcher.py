"""A dispatcher sends robots from place to place, and gives tasks of robots that fail or leave to others."""

import pytest

from ppaas.tasks.dispatcher import GONE_AFTER, MOST_FAILURES, REST, Dispatcher
from ppaas.tasks.orders import Cancel, Order, RobotNow, Send, StoreTask
from ppaas.tasks.records import Place, Task

A, B, C = (0.0, 0.0, 0.0), (10.0, 0.0, 0.0), (20.0, 0.0, 0.0)


def task(name: str = "t", *places: Place, kind: str = "go_to", **fields: object) -> Task:
    return Task(id=name, kind=kind, places=places or (B,), **fields)  # type: ignore[arg-type]


def at(**places: Place | None) -> dict[str, RobotNow]:
    return {name: RobotNow(place) for name, place in places.items()}


def sent(orders: list[Order]) -> list[tuple[str, str, Place]]:
    return [(order.robot, order.goal_id, order.place) for order in orders if isinstance(order, Send)]


def stored(orders: list[Order]) -> list[Task]:
    return [order.task for order in orders if isinstance(order, StoreTask)]


def begun(*tasks: Task, **robots: Place | None) -> Dispatcher:
    dispatcher = Dispatcher(tasks, 0.0)
    dispatcher.see(at(**robots), 0.0)
    dispatcher.decide(0.0)
    return dispatcher


def test_a_task_is_stored_before_its_goal_is_sent() -> None:
    dispatcher = Dispatcher([task()], 0.0)
    dispatcher.see(at(r=A), 0.0)
    orders = dispatcher.decide(1.0)
    assert [type(order) for order in orders] == [StoreTask, Send]
    assert sent(orders) == [("r", "task-t-0-0", B)]
    assert (stored(orders)[0].state, stored(orders)[0].robot, stored(orders)[0].assigned) == ("assigned", "r", 1.0)
    assert dispatcher.decide(2.0) == []


def test_the_legs_of_a_task_follow_each_other() -> None:
    dispatcher = begun(task("t", B, C, kind="pick_drop"), r=A)
    orders = dispatcher.goal_ended("r", "task-t-0-0", "succeeded", "", 5.0)
    assert sent(orders) == [("r", "task-t-1-0", C)]
    assert (stored(orders)[0].state, stored(orders)[0].begun) == ("active", 5.0)
    [done] = stored(dispatcher.goal_ended("r", "task-t-1-0", "succeeded", "", 9.0))
    assert (done.state, done.robot, done.ended, done.reason) == ("done", "r", 9.0, "")
    assert not dispatcher.tasks


def test_a_patrol_goes_around_as_often_as_it_is_told() -> None:
    dispatcher = begun(task("t", A, B, kind="patrol", rounds=3), r=A)
    visited = []
    goal, place = "task-t-0-0", A
    while dispatcher.tasks:
        visited.append(place)
        orders = dispatcher.goal_ended("r", goal, "succeeded", "", 1.0)
        for _, goal, place in sent(orders):  # noqa: B007
            pass
    assert visited == [A, B] * 3


def test_a_dispatcher_after_a_restart_sends_the_same_goal_once_the_robot_is_there() -> None:
    [kept] = begun(task("t", B, C, kind="pick_drop"), r=A).tasks.values()
    dispatcher = Dispatcher([kept], 100.0)
    assert dispatcher.see({}, 110.0) == []
    assert sent(dispatcher.see(at(r=A), 120.0)) == [("r", "task-t-0-0", B)]
    assert dispatcher.see(at(r=A), 121.0) == []


def test_a_robot_that_fails_gives_its_task_to_another_and_rests() -> None:
    dispatcher = begun(task(), near=A, far=C)
    [(first, goal, _)] = sent(Dispatcher([*dispatcher.tasks.values()], 0.0).see(at(near=A, far=C), 0.0))
    [back] = stored(dispatcher.goal_ended(first, goal, "aborted", "no way", 1.0))
    assert (back.state, back.robot, back.failures) == ("queued", "", 1)
    assert "no way" in back.reason
    other = "far" if first == "near" else "near"
    assert sent(dispatcher.decide(1.0)) == [(other, "task-t-0-1", B)]


def test_a_robot_alone_tries_again_after_its_rest_and_not_forever() -> None:
    dispatcher, now = begun(task(), r=A), 0.0
    for attempt in range(MOST_FAILURES):
        [record] = stored(dispatcher.goal_ended("r", f"task-t-0-{attempt}", "aborted", "", now))
        assert dispatcher.decide(now + 1.0) == []
        now += REST
        dispatcher.see(at(r=A), now)
        dispatcher.decide(now)
    assert record.state == "failed"
    assert str(MOST_FAILURES) in record.reason


@pytest.mark.parametrize("outcome", ["aborted", "canceled", "rejected"])
def test_what_was_picked_is_not_handed_over(outcome: str) -> None:
    dispatcher = begun(task("t", B, C, kind="pick_drop"), r=A, other=A)
    [robot] = {one.robot for one in dispatcher.tasks.values()}
    dispatcher.goal_ended(robot, "task-t-0-0", "succeeded", "", 1.0)
    [failed] = stored(dispatcher.goal_ended(robot, "task-t-1-0", outcome, "stuck", 2.0))  # type: ignore[arg-type]
    assert failed.state == "failed"
    assert "stuck" in failed.reason
    assert "picked" in failed.reason


def test_a_goal_that_the_clone_has_forgotten_is_sent_again() -> None:
    dispatcher = begun(task("t", B, C, kind="pick_drop"), r=A)
    dispatcher.goal_ended("r", "task-t-0-0", "succeeded", "", 1.0)
    assert sent(dispatcher.goal_ended("r", "task-t-1-0", "lost", "", 2.0)) == [("r", "task-t-1-1", C)]


def test_a_robot_that_leaves_gives_its_task_back_after_a_while() -> None:
    dispatcher = begun(task(), r=A)
    assert dispatcher.see({}, 1.0) == dispatcher.see({}, GONE_AFTER) == []
    [back] = stored(dispatcher.see({}, GONE_AFTER + 1.0))
    assert (back.state, back.robot, back.failures) == ("queued", "", 0)
    dispatcher.see(at(s=C), GONE_AFTER + 2.0)
    assert sent(dispatcher.decide(GONE_AFTER + 2.0)) == [("s", "task-t-0-1", B)]


def test_the_time_counts_from_the_loss_of_the_robot_if_that_is_known() -> None:
    [kept] = begun(task(), r=A).tasks.values()
    dispatcher = Dispatcher([kept], 100.0)
    assert dispatcher.see({}, 101.0) == []
    [back] = stored(dispatcher.see({}, 102.0, {"r": 102.0 - GONE_AFTER - 1.0}))
    assert (back.state, back.failures) == ("queued", 0)


def test_a_goal_that_ends_while_its_robot_is_away_is_sent_again_once_it_is_back() -> None:
    dispatcher = begun(task(), r=A)
    dispatcher.see({}, 10.0)
    assert dispatcher.away == ["r"]
    orders = dispatcher.goal_ended("r", "task-t-0-0", "aborted", "no odometry", 11.0)
    assert [(kept.state, kept.failures) for kept in stored(orders)] == [("assigned", 0)]
    assert sent(orders) == []
    assert sent(dispatcher.see(at(r=A), 20.0)) == [("r", "task-t-0-1", B)]


def test_a_goal_that_somebody_cancels_while_its_robot_is_away_is_a_failure() -> None:
    dispatcher = begun(task(), r=A)
    dispatcher.see({}, 10.0)
    [back] = stored(dispatcher.goal_ended("r", "task-t-0-0", "canceled", "", 11.0))
    assert (back.state, back.failures) == ("queued", 1)


def test_a_robot_that_leaves_with_what_it_picked_fails_its_task() -> None:
    dispatcher = begun(task("t", B, C, kind="pick_drop"), r=A)
    dispatcher.goal_ended("r", "task-t-0-0", "succeeded", "", 1.0)
    [failed] = stored(dispatcher.see({}, GONE_AFTER + 2.0))
    assert (failed.state, "picked" in failed.reason) == ("failed", True)


def test_a_robot_that_comes_back_in_time_goes_on() -> None:
    dispatcher = begun(task(), r=A)
    dispatcher.see({}, 10.0)
    assert sent(dispatcher.see(at(r=A), 20.0)) == [("r", "task-t-0-0", B)]


def test_a_cancelled_task_stops_its_robot() -> None:
    dispatcher = begun(task(), r=A)
    assert dispatcher.withdraw("t") == [Cancel("r", "task-t-0-0")]
    assert dispatcher.withdraw("t") == dispatcher.withdraw("unknown") == []
    assert dispatcher.goal_ended("r", "task-t-0-0", "canceled", "", 1.0) == []


def test_goals_of_tasks_that_nobody_knows_are_cancelled() -> None:
    robots = {"r": RobotNow(A, goals=frozenset({"task-old-0-0", "rest-7"}))}
    assert Dispatcher([], 0.0).see(robots, 0.0) == [Cancel("r", "task-old-0-0")]


def test_a_robot_that_somebody_else_leads_gets_no_task() -> None:
    dispatcher = Dispatcher([task()], 0.0)
    dispatcher.see({"r": RobotNow(A, goals=frozenset({"rest-7"}))}, 0.0)
    assert dispatcher.decide(0.0) == []
    dispatcher.see(at(lost=None), 1.0)
    assert dispatcher.decide(1.0) == []


def test_a_task_moves_to_a_robot_that_comes_free_nearby_and_the_other_one_stops() -> None:
    dispatcher = begun(task("t", C), far=A)
    dispatcher.see(at(far=A, near=C), 1.0)
    orders = dispatcher.decide(1.0)
    assert sent(orders) == [("near", "task-t-0-1", C)]
    assert Cancel("far", "task-t-0-0") in orders
    begun_one = begun(task("t", B, C, kind="patrol"), far=A)
    begun_one.goal_ended("far", "task-t-0-0", "succeeded", "", 1.0)
    begun_one.see(at(far=B, near=C), 2.0)
    assert begun_one.decide(2.0) == []


def test_a_task_that_nobody_began_before_its_deadline_fails() -> None:
    dispatcher = Dispatcher([task(deadline=5.0)], 0.0)
    assert dispatcher.decide(5.0) == []
    [failed] = stored(dispatcher.decide(5.1))
    assert (failed.state, failed.ended) == ("failed", 5.1)
    assert "deadline" in failed.reason
