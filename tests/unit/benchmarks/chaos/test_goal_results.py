"""Goals must end once, or be reported lost."""

from benchmarks.chaos.goal_sender import GoalResults


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
