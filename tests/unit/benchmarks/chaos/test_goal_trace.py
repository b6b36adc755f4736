"""The trace of a goal has the distance of its robot and the numbers of its messages in each period."""

from benchmarks.chaos.goal_sender import PERIOD, GoalTrace, Standing


def test_an_entry_is_added_once_a_period_with_what_has_happened_in_it() -> None:
    standing = Standing(0.0, 0.0, 0.0, 5.0, 100, 110)
    trace = GoalTrace(3.0, 4.0, lambda: standing)
    standing = Standing(0.0, 0.0, 0.2, 25.0, 300, 410)
    trace.look(PERIOD - 1.0)
    assert str(trace) == ""
    trace.look(PERIOD)
    standing = Standing(3.0, 0.0, 0.0, 65.0, 301, 411)
    trace.look(PERIOD + 1.0)
    trace.look(2 * PERIOD)
    assert str(trace).split("; ") == [
        "after 40 s 5.0 m away, 0.2 m lost, 20 s simulated, 200 commands in 300 cycles",
        "after 80 s 4.0 m away, 0.0 m lost, 40 s simulated, 1 commands in 1 cycles",
    ]
