"""Patrols of the bench."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np

from benchmarks.people.runs.robot import IDLE, Patrol
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.people_coordination import FollowOrder, PeopleState
from robots.sim.shortest_paths import ShortestPaths
from tests.support.world.rooms import room

NOBODY = PeopleState(Header(), 0)
ORDERED = PeopleState(Header(), 0, orders=[FollowOrder("r0", 1, 2.0, Time())])


class Clone:
    """Records what a patrol does."""

    def __init__(self) -> None:
        self.calls: list[str] = []
        self.end: object = None

    def send_to(self, _goal: Pose2D) -> None:
        self.end = None
        self.calls.append("go")

    def cancel(self) -> None:
        self.calls.append("cancel")


def patrol_of(clone: Clone) -> Patrol:
    body = SimpleNamespace(base=SimpleNamespace(pose=Pose2D(2.0, 2.0)))
    robot = cast("Any", SimpleNamespace(id="r0", clone=clone, body=body))
    return Patrol(robot, ShortestPaths(room(6.0, 5.0), 0.3, np.random.default_rng(0)))


def test_a_robot_on_patrol_stops_once_it_is_wanted() -> None:
    clone = Clone()
    patrol = patrol_of(clone)
    patrol.take(NOBODY, 0.5 * IDLE)
    assert clone.calls == []
    patrol.take(NOBODY, IDLE)
    patrol.take(NOBODY, IDLE + 0.2)
    patrol.take(ORDERED, IDLE + 0.4)
    patrol.take(ORDERED, IDLE + 0.6)
    assert clone.calls == ["go", "cancel"]


def test_a_robot_that_has_just_arrived_is_not_stopped_when_it_is_wanted() -> None:
    clone = Clone()
    patrol = patrol_of(clone)
    patrol.take(NOBODY, IDLE)
    clone.end = "reached"
    patrol.take(ORDERED, IDLE + 0.2)
    assert clone.calls == ["go"]
