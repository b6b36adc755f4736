"""Rules on goals: why there is no ``cmd_vel``."""

import msgspec
import pytest

from ppaas.diagnosis.observations.facts import GoalFacts, MotionFacts, NodeFacts
from ppaas.diagnosis.rules.driving import goals
from ppaas.messages.actionlib_msgs import Status
from tests.support.world.diagnosed_robot import LINK, healthy


@pytest.mark.parametrize(
    ("goal", "commands", "kind", "level"),
    [
        (GoalFacts(), 0, "no-goal", "ok"),
        (GoalFacts(name="g", status=Status.SUCCEEDED, text="Goal reached."), 0, "no-goal", "ok"),
        (GoalFacts(name="g", status=Status.ABORTED, text="Failed to find a valid plan."), 0, "goal-failed", "warn"),
        (GoalFacts(name="g", status=Status.REJECTED, text="outside the map"), 0, "goal-failed", "warn"),
        (GoalFacts(name="g", status=Status.ACTIVE, text="waiting: no odometry for 2.0 s"), 40, "goal-waits", "error"),
        (GoalFacts(name="g", status=Status.ACTIVE, text="recovering by wait"), 40, "goal-recovers", "warn"),
        (GoalFacts(name="g", status=Status.ACTIVE, text="planning"), 0, "goal-plans", "ok"),
        (GoalFacts(name="g", status=Status.ACTIVE, text="controlling: x"), 40, "goal-active", "ok"),
        (GoalFacts(name="g", status=77, text="of another release"), 40, "goal-active", "ok"),
    ],
)
def test_reason_for_no_command_is_given(goal: GoalFacts, commands: int, kind: str, level: str) -> None:
    [finding] = goals(healthy(goal=goal, motion=MotionFacts(commands=commands), robot="tb1"))
    assert (finding.kind, finding.level) == (kind, level)
    if kind == "goal-waits":
        assert "no odometry for 2.0 s" in finding.text
    if kind in ("no-goal", "goal-failed"):
        assert "ppaas robot go tb1" in finding.advice


def test_robot_that_does_not_hear_cmd_vel_is_found_first() -> None:
    link = msgspec.structs.replace(LINK, subscribed=("map",))
    assert [finding.kind for finding in goals(healthy(link=link))] == ["cmd-vel-unheard", "no-goal"]
    at_home = [NodeFacts(name="move_base", home="robot")]
    assert [finding.kind for finding in goals(healthy(link=link, nodes=at_home))] == ["no-goal"]


def test_a_robot_that_follows_paths_itself_hears_paths_instead_of_velocities() -> None:
    paths = msgspec.structs.replace(LINK, subscribed=("follow_path/goal",))
    assert "cmd-vel-unheard" not in {one.kind for one in goals(healthy(follows_paths=True, link=paths))}
    found = [one.kind for one in goals(healthy(follows_paths=True, link=LINK))]
    assert found[0] == "paths-unheard"
    driving = healthy(follows_paths=True, link=paths, goal=GoalFacts(name="g", status=1, text="controlling"))
    assert [one.text for one in goals(driving)] == [
        "The robot is led along paths, which it follows itself (controlling)."
    ]
