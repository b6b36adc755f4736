"""A goal's end is learned from its result or from the status lists."""

import asyncio

from ppaas.messages.actionlib_msgs import GoalID, GoalStatus, GoalStatusArray, Status
from ppaas.messages.move_base_msgs import MoveBaseActionResult
from ppaas.messages.std_msgs import Header
from robots.client.goal_tracker import MIN_LISTS, SETTLED, TrackedGoal


def status(goal: str, number: Status) -> GoalStatus:
    return GoalStatus(GoalID(id=goal), int(number))


def listed(following: TrackedGoal, times: int, *statuses: GoalStatus, since: float = 0.0) -> float:
    """Deliver status lists, one per second; return the time of the last."""
    for number in range(times):
        following.on_status(GoalStatusArray(status_list=list(statuses)), since + number)
    return since + times - 1


async def test_a_result_ends_its_goal_and_no_other() -> None:
    following = TrackedGoal("mine")
    following.on_result(MoveBaseActionResult(Header(), status("other", Status.SUCCEEDED)))
    assert not following.result.done()
    following.on_result(MoveBaseActionResult(Header(), status("mine", Status.ABORTED)))
    following.on_result(MoveBaseActionResult(Header(), status("mine", Status.SUCCEEDED)))
    assert (await asyncio.wait_for(following.result, 1.0)).status == Status.ABORTED


async def test_lists_that_agree_for_a_while_tell_of_an_end_whose_result_is_lost() -> None:
    following = TrackedGoal("mine")
    now = listed(following, 3, status("other", Status.SUCCEEDED), status("mine", Status.ACTIVE))
    assert not following.is_over(now + 2.0 * SETTLED)
    now = listed(following, 2, status("mine", Status.SUCCEEDED), since=10.0)
    assert not following.is_over(now)
    assert following.is_over(10.0 + SETTLED + 0.1) and following.status.status == Status.SUCCEEDED


async def test_a_goal_is_unknown_when_several_lists_in_a_row_do_not_have_it() -> None:
    following = TrackedGoal("mine")
    listed(following, MIN_LISTS - 1)
    assert not following.is_unknown(100.0)
    now = listed(following, 1, status("mine", Status.ACTIVE), since=100.0)
    assert not following.is_unknown(now + 100.0)
    now = listed(following, MIN_LISTS, status("other", Status.ACTIVE), since=200.0)
    assert not following.is_unknown(now)
    assert following.is_unknown(200.0 + SETTLED + 0.1)
