"""A goal's end is learned from its result or from the status lists."""

import asyncio

from ppaas.messages.actionlib_msgs import GoalID, GoalStatus, GoalStatusArray, Status
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.move_base_msgs import MoveBaseActionResult
from ppaas.navigation.goal_watch import MIN_LISTS, SETTLED
from robots.client.move_base import TrackedGoal


def status(goal: str, number: Status) -> GoalStatus:
    return GoalStatus(GoalID(id=goal), int(number))


def listed(tracked: TrackedGoal, times: int, *statuses: GoalStatus, since: float = 0.0) -> float:
    """Deliver status lists, one per second; return the time of the last."""
    for number in range(times):
        tracked.on_status(GoalStatusArray(status_list=list(statuses)), since + number)
    return since + times - 1


async def test_a_result_ends_only_its_own_goal() -> None:
    tracked = TrackedGoal("mine")
    tracked.on_result(MoveBaseActionResult(Header(), status("other", Status.SUCCEEDED)))
    assert not tracked.result.done()
    tracked.on_result(MoveBaseActionResult(Header(), status("mine", Status.ABORTED)))
    tracked.on_result(MoveBaseActionResult(Header(), status("mine", Status.SUCCEEDED)))
    assert (await asyncio.wait_for(tracked.result, 1.0)).status == Status.ABORTED


async def test_repeated_terminal_statuses_end_a_goal_without_a_result() -> None:
    tracked = TrackedGoal("mine")
    now = listed(tracked, 3, status("other", Status.SUCCEEDED), status("mine", Status.ACTIVE))
    listed(tracked, MIN_LISTS - 1, status("mine", Status.SUCCEEDED), since=now)
    assert not tracked.result.done()
    listed(tracked, 2, status("mine", Status.SUCCEEDED), since=now + SETTLED)
    assert (tracked.result.result().status, tracked.has_result) == (Status.SUCCEEDED, False)


async def test_a_goal_missing_from_several_status_lists_is_lost() -> None:
    tracked = TrackedGoal("mine")
    now = listed(tracked, MIN_LISTS - 1)
    now = listed(tracked, 1, status("mine", Status.ACTIVE), since=now + 100.0)
    assert tracked.status.status == Status.ACTIVE
    listed(tracked, MIN_LISTS + 2, status("other", Status.ACTIVE), since=now)
    assert tracked.result.result().status == Status.LOST


async def test_a_result_after_the_end_by_lists_changes_nothing() -> None:
    tracked = TrackedGoal("mine")
    listed(tracked, MIN_LISTS + 2)
    tracked.on_result(MoveBaseActionResult(Header(), status("mine", Status.SUCCEEDED)))
    assert (tracked.result.result().status, tracked.has_result) == (Status.LOST, False)
