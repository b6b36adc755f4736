"""Group of robots: the baseline of following, and patrols."""

from types import SimpleNamespace
from typing import Any, cast

import msgspec
import numpy as np
import pytest

from benchmarks.people.runs.group import NearestRobot
from benchmarks.people.runs.robot import IDLE, Patrol
from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point, Pose, PoseWithCovariance
from ppaas.messages.people_coordination import FollowOrder, GroupRobot, PeopleReport, PeopleState, TrackedPerson
from robots.sim.shortest_paths import ShortestPaths
from tests.support.world.rooms import room


@pytest.fixture(scope="module")
def nearest() -> NearestRobot:
    """Return the baseline in a room of two robots that can follow."""
    made = NearestRobot(build_layers(room(10.0, 4.0), robot_radius=0.18).costmap)
    for robot in ("a", "b"):
        made.note(PeopleReport(Header(), robot, PoseWithCovariance(Pose.of(Pose2D(0.0, 0.0))), can_follow=True))
    return made


def state(x: float, *, seen_by: tuple[str, ...] = ("a/1", "b/1")) -> PeopleState:
    person = TrackedPerson(7, Point(x, 2.0), Point(0.0, 0.0), [0.01, 0.0, 0.0, 0.01], seen_by=list(seen_by))
    robots = [GroupRobot("a", Point(1.0, 2.0), 0.1), GroupRobot("b", Point(9.0, 2.0), 0.1)]
    return PeopleState(Header(), 1, [person], [], robots)


def follower(nearest: NearestRobot, told: PeopleState, now: float = 0.0) -> str:
    (order,) = nearest.orders(told, now)
    assert order.person == 7
    return order.robot


def test_the_robot_with_the_shortest_path_follows_at_any_time(nearest: NearestRobot) -> None:
    assert [follower(nearest, state(x)) for x in (4.9, 5.1, 4.9)] == ["a", "b", "a"]


def test_only_a_robot_that_sees_the_person_follows(nearest: NearestRobot) -> None:
    assert follower(nearest, state(2.0, seen_by=("b/1",))) == "b"


def test_the_last_order_stays_while_the_person_is_hidden_and_known(nearest: NearestRobot) -> None:
    assert follower(nearest, state(2.0)) == "a"
    hidden = state(2.0, seen_by=())
    assert follower(nearest, hidden) == "a"
    assert nearest.orders(msgspec.structs.replace(hidden, people=[]), 0.0) == []


def test_a_person_outside_the_free_space_is_not_followed(nearest: NearestRobot) -> None:
    assert follower(nearest, state(2.0)) == "a"
    assert follower(nearest, state(-5.0)) == "a"  # the last order


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
