"""Rules on goals, commands and motion."""

import msgspec
import pytest

from ppaas.diagnosis.observations.facts import GoalFacts, HandFacts, MotionFacts, NodeFacts, TopicFacts
from ppaas.diagnosis.rules.driving import goals, motion
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


def test_a_stopped_robot_is_found_with_who_stopped_it_and_how_to_release_it() -> None:
    waits = GoalFacts(name="g", status=Status.ACTIVE, text="waiting: stopped by 'ann'")
    [finding] = goals(healthy(goal=waits, stopped="stopped by 'ann' since noon: a pallet fell", robot="tb1"))
    assert (finding.kind, finding.level) == ("robot-stopped", "error")
    assert finding.text.endswith("stopped by 'ann' since noon: a pallet fell. Its goal waits.")
    assert "ppaas release tb1" in finding.advice
    [finding] = goals(healthy(stopped="all robots are stopped by 'ann'", hand=HandFacts(driver="bob", mode="locked")))
    assert "goal" not in finding.text


@pytest.mark.parametrize(
    ("mode", "text", "level", "said"),
    [
        ("driving", "", "ok", "bob drives the robot by hand"),
        ("blocked", "", "warn", "something is in the way"),
        ("locked", "commands came 0.4 s late", "warn", "it stands: commands came 0.4 s late."),
    ],
)
def test_a_robot_that_is_driven_by_hand_is_found_with_its_driver(mode: str, text: str, level: str, said: str) -> None:
    ended = GoalFacts(name="g", status=Status.PREEMPTED, text="bob drives the robot by hand")
    [finding] = goals(healthy(goal=ended, hand=HandFacts(driver="bob", mode=mode, text=text)))
    assert (finding.kind, finding.level) == ("driven-by-hand", level)
    assert said in finding.text


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


DRIVES = {"commands": 90, "ordered": 1.0, "ordered_turn": 1.0, "ordered_path": 1.2}
FOLLOWS = {"moved": 0.9, "moved_turn": 0.9, "moved_path": 1.1}


@pytest.mark.parametrize(
    ("changed", "kinds"),
    [
        ({}, []),
        ({"moved": 0.0, "moved_turn": 0.0, "moved_path": 0.0}, ["base-does-not-follow"]),
        ({"moved_turn": -0.9}, ["turn-reversed"]),
        ({"moved": -0.9}, ["drive-reversed"]),
        ({"jump": 3.0}, ["odom-jumps"]),
        ({"ordered_path": 0.1, "moved_path": 0.0}, []),
    ],
)
def test_base_that_does_not_obey_is_found(changed: dict[str, float], kinds: list[str]) -> None:
    found = motion(healthy(motion=MotionFacts(**DRIVES | FOLLOWS | changed)))
    assert [finding.kind for finding in found] == kinds


def test_robot_without_odometry_is_not_blamed_for_standing_still() -> None:
    assert list(motion(healthy(topics=[], motion=MotionFacts(**DRIVES)))) == []


def test_another_publisher_of_commands_is_found() -> None:
    seen = healthy(topics=[*healthy().topics, TopicFacts(name="cmd_vel", senders=1)])
    assert [finding.kind for finding in motion(seen)] == ["cmd-vel-others"]
    seen.nodes = [NodeFacts(name="move_base", home="robot")]
    assert list(motion(seen)) == []  # it is Move Base that publishes there
