"""Rules on the motion of a robot."""

import pytest

from ppaas.diagnosis.observations.facts import MotionFacts, NodeFacts, TopicFacts
from ppaas.diagnosis.rules.driving import motion
from tests.support.world.diagnosed_robot import healthy

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
