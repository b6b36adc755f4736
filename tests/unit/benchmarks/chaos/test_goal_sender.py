"""Goals of the chaos bench: the result of each, and the trace of its way."""

from benchmarks.chaos.goal_sender import PERIOD, GoalResults, GoalTrace, Standing


def test_missing_repeated_and_unknown_results_are_reported() -> None:
    errors: list[str] = []
    goals = GoalResults("r", errors.append)
    goals.send("a")
    goals.send("b")
    goals.result("a")
    goals.end("result", "SUCCEEDED")
    assert errors == []
    goals.result("a")
    goals.result("c")
    goals.missing("b", 240.0, "ACTIVE")
    goals.forgotten("b")
    assert errors == [
        "r received 2 results of a",
        "r received the result of a goal that it never sent: c",
        "r: b did not end within 240 s: ACTIVE",
        "r: the clone lost b without a new session",
    ]
    assert (goals.sent, goals.endings["result"], goals.statuses["SUCCEEDED"]) == (2, 1, 1)


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
