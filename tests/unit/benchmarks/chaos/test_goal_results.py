"""Goals must end once, or be reported lost."""

from benchmarks.chaos.goal_results import GoalResults


def test_each_goal_has_one_result_and_no_more() -> None:
    told: list[str] = []
    goals = GoalResults("r", told.append)
    goals.send("a")
    goals.send("b")
    goals.result("a")
    goals.end("result", "SUCCEEDED")
    assert told == []
    goals.result("a")
    goals.result("c")
    goals.missing("b", 240.0)
    goals.forgotten("b")
    assert told == [
        "r received 2 results of a",
        "r received the result of a goal that it never sent: c",
        "r: b did not end within 240 s",
        "r: the clone lost b without a new session",
    ]
    assert (goals.sent, goals.endings["result"], goals.statuses["SUCCEEDED"]) == (2, 1, 1)
