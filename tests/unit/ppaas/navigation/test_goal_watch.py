"""One rule ends a goal without its result: lists in a row, over some time, that do not show it as active."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import MalformedMessage
from ppaas.messages.actionlib_msgs import GoalID, GoalStatus, Status
from ppaas.navigation.goal_watch import LOST_TEXT, MIN_LISTS, SETTLED, GoalWatch

ACTIVE = [Status.PENDING, Status.ACTIVE, Status.PREEMPTING, Status.RECALLING]
FINAL = [status for status in Status if status.terminal]

gaps = st.floats(0.0, 10.0)
shown = st.sampled_from([None, *Status])
"""Status of the goal in a list; None if the list lacks it."""

histories = st.lists(st.tuples(gaps, shown), max_size=40)


def named(status: Status | None, text: str = "why") -> list[GoalStatus]:
    """Return a list with another goal, and with the watched one if it has a status."""
    others = [GoalStatus(GoalID(id="other"), Status.SUCCEEDED)]
    return others if status is None else [*others, GoalStatus(GoalID(id="mine"), status, text)]


def watched(history: list[tuple[float, Status | None]]) -> tuple[list[Status | None], GoalWatch]:
    """Return what each list of a history made of the goal, and the watch."""
    watch, now, found = GoalWatch("mine"), 0.0, []
    for gap, status in history:
        now += gap
        found.append(watch.see(named(status), now))
    return found, watch


def test_a_goal_that_lists_lack_is_lost_after_enough_lists_and_time() -> None:
    found, watch = watched([(0.0, Status.ACTIVE), *[(SETTLED / 3, None)] * 4])
    assert found == [None, None, None, None, Status.LOST]
    assert (watch.text, watch.has_ended) == (LOST_TEXT, False)


def test_many_lists_in_a_short_time_are_not_enough() -> None:
    assert set(watched([(0.1, None)] * 40)[0]) == {None}


def test_few_lists_over_a_long_time_are_not_enough() -> None:
    assert watched([(100.0, None)] * MIN_LISTS)[0] == [None] * (MIN_LISTS - 1) + [Status.LOST]


@pytest.mark.parametrize("final", FINAL)
def test_a_goal_whose_end_is_listed_ends_with_it_even_if_later_lists_lack_it(final: Status) -> None:
    found, watch = watched([(0.0, Status.ACTIVE), (1.0, final), *[(2.0, None)] * 3])
    assert found == [None, None, None, None, final]
    assert (watch.has_ended, watch.text) == (True, "why")


def test_the_last_status_of_a_list_counts() -> None:
    watch = GoalWatch("mine")
    watch.see([*named(Status.SUCCEEDED), *named(Status.ACTIVE)], 0.0)
    assert watch.status is Status.ACTIVE


def test_an_unknown_status_changes_nothing() -> None:
    watch = GoalWatch("mine")
    watch.see(named(Status.ACTIVE), 0.0)
    with pytest.raises(MalformedMessage, match="99 is not a goal status"):
        watch.see([GoalStatus(GoalID(id="mine"), 99)], 1.0)
    assert watch.status is Status.ACTIVE


@given(histories)
def test_a_goal_ends_exactly_by_the_rule(history: list[tuple[float, Status | None]]) -> None:
    """The rule as it is written: look back from each list to the last one that showed the goal as active."""
    found, _ = watched(history)
    times = [sum(gap for gap, _ in history[: at + 1]) for at in range(len(history))]
    for at, verdict in enumerate(found):
        idle = []
        for back in range(at, -1, -1):
            if history[back][1] in ACTIVE:
                break
            idle.append(back)
        span = times[idle[0]] - times[idle[-1]] if idle else 0.0
        if len(idle) >= MIN_LISTS and span >= SETTLED + 1e-6:
            last = next((status for _, status in history[at::-1] if status is not None), Status.PENDING)
            assert verdict is (last if last.terminal else Status.LOST)
        elif len(idle) < MIN_LISTS or span < SETTLED - 1e-6:
            assert verdict is None


@given(histories, st.lists(st.tuples(gaps, st.sampled_from(ACTIVE)), min_size=1, max_size=40))
def test_a_goal_that_lists_keep_naming_is_never_lost(
    before: list[tuple[float, Status | None]], naming: list[tuple[float, Status]]
) -> None:
    found, _ = watched([*before, *naming])
    assert found[len(before) :] == [None] * len(naming)


@given(st.lists(st.tuples(gaps, st.none()), max_size=MIN_LISTS - 2), st.floats(0.0, 1e9))
def test_lists_that_stop_coming_do_not_end_a_goal(before: list[tuple[float, None]], silence: float) -> None:
    found, _ = watched([(0.0, Status.ACTIVE), *before, (silence, None)])
    assert set(found) == {None}


@given(histories)
def test_only_a_goal_whose_end_no_list_had_since_it_was_active_is_lost(
    history: list[tuple[float, Status | None]],
) -> None:
    found, _ = watched(history)
    for at, verdict in enumerate(found):
        if verdict is Status.LOST:
            seen = [status for _, status in history[: at + 1] if status is not None]
            assert not seen or not seen[-1].terminal or seen[-1] is Status.LOST
