"""Robots with tasks dock at docks, undock before they drive, and report why they did not."""

from typing import Any

import pytest

from engine.control.tasks.docking import REPORTED, DockingClient
from engine.protocols import refusals, robot_link
from engine.specs.robot_report import StateReport
from ppaas.clock import ManualClock
from ppaas.errors import Unavailable
from ppaas.messages.actionlib_msgs import Status
from ppaas.nodes.nav2_actions import DOCK_ROBOT, UNDOCK_ROBOT
from tests.support.endpoints.still_place import StillRobot, delivered

DOCK, UNDOCK = DOCK_ROBOT.goal.name, UNDOCK_ROBOT.goal.name


class Scene:
    """A robot with a client that docks it."""

    def __init__(self) -> None:
        self.place, self.clock, self.ends = StillRobot(), ManualClock(0.0), 0
        self.place.topics[DOCK] = robot_link.TopicInfo(DOCK, "nav2_msgs/DockRobotActionGoal", False)
        self.client = DockingClient(self.place, self.count, monotonic=self.clock)

    def count(self) -> None:
        self.ends += 1

    def report(self, docked: str) -> None:
        self.place.say(robot_link.ContainerBeat(busy=False, report=StateReport(docked=docked)))

    def end(self, topic: str, goal: str, status: Status, text: str = "") -> None:
        self.place.publish_json(topic, {"status": {"goal_id": {"id": goal}, "status": int(status), "text": text}})

    def said(self) -> list[tuple[str, Any]]:
        return [(topic, message) for topic, message in delivered(self.place)]


@pytest.fixture
def scene() -> Scene:
    return Scene()


def test_a_goal_to_dock_is_sent_once_and_ends_with_its_result(scene: Scene) -> None:
    for _ in range(2):
        scene.client.dock("g", "a")
    [(topic, message)] = scene.said()
    assert (topic, message["goal_id"]["id"], message["goal"]["dock_id"]) == (DOCK, "g", "a")
    assert [(goal.id, goal.state) for goal in scene.client.goals()] == [("g", "pending")]
    scene.end(DOCK_ROBOT.result.name, "other", Status.SUCCEEDED)
    scene.end(DOCK_ROBOT.result.name, "g", Status.ABORTED, "contact-without-charge")
    [goal] = scene.client.goals()
    assert (goal.state, goal.text, scene.ends) == ("aborted", "contact-without-charge", 1)


def test_a_goal_whose_result_is_lost_ends_by_the_lists(scene: Scene) -> None:
    scene.client.dock("g", "a")
    for state in (Status.ACTIVE, Status.SUCCEEDED):
        for _ in range(10):
            scene.clock.advance(1.0)
            status = {"goal_id": {"id": "g"}, "status": int(state)}
            scene.place.publish_json(DOCK_ROBOT.status.name, {"status_list": [status]})
            scene.place.publish_json(UNDOCK_ROBOT.status.name, {"status_list": []})
        assert [goal.state for goal in scene.client.goals()] == [state.name.lower()]


def test_a_docked_robot_undocks_before_it_goes_on(scene: Scene) -> None:
    scene.report("docked at dock 'a'")
    assert scene.client.is_docked and scene.client.stands_at("a") and not scene.client.stands_at("b")
    gone: list[int] = []
    scene.client.undock("g", lambda: gone.append(1))
    scene.client.undock("g", lambda: gone.append(2))
    assert [topic for topic, _ in scene.said()] == [UNDOCK]
    scene.end(UNDOCK_ROBOT.result.name, "g", Status.SUCCEEDED)
    assert (gone, scene.client.goals(), scene.client.is_docked) == ([2], [], False)
    scene.clock.advance(REPORTED + 1.0)
    assert scene.client.is_docked


@pytest.mark.parametrize("then", [Unavailable("too much"), None])
def test_a_robot_that_does_not_undock_or_go_on_fails_its_goal(scene: Scene, then: Unavailable | None) -> None:
    def go() -> None:
        assert then is not None
        raise then

    scene.client.undock("g", go)
    scene.end(UNDOCK_ROBOT.result.name, "g", Status.ABORTED if then is None else Status.SUCCEEDED, "it is stuck")
    [goal] = scene.client.goals()
    assert (goal.state, goal.text) == ("aborted", "it did not undock: it is stuck" if then is None else "too much")


def test_a_cancel_and_a_refusal_are_those_of_the_action(scene: Scene) -> None:
    scene.client.undock("u", lambda: None)
    scene.client.cancel("u")
    scene.client.cancel("unknown")
    assert [topic for topic, _ in scene.said()] == [UNDOCK, UNDOCK_ROBOT.cancel.name]
    scene.place.say(robot_link.MessageRefused(1, UNDOCK, refusals.Refusal("unavailable", "no node"), 1))
    [goal] = scene.client.goals()
    assert goal.state == "rejected"


def test_a_goal_that_another_master_sent_is_cancelled_too(scene: Scene) -> None:
    status = {"goal_id": {"id": "old"}, "status": int(Status.ACTIVE)}
    scene.place.publish_json(DOCK_ROBOT.status.name, {"status_list": [status]})
    assert scene.client.followed == {"old"}
    scene.client.cancel("old")
    assert scene.said() == [(DOCK_ROBOT.cancel.name, {"stamp": {"secs": 0, "nsecs": 0}, "id": "old"})]


def test_a_place_that_closes_loses_goals(scene: Scene) -> None:
    scene.client.dock("g", "a")
    assert scene.place.clients == 1
    scene.client.closed(Unavailable("the place was closed"))
    assert [goal.state for goal in scene.client.goals()] == ["lost"]
    scene.client.leave()
    assert scene.place.clients == 0


def test_clones_of_earlier_releases_do_not_dock() -> None:
    place = StillRobot()
    client = DockingClient(place)
    assert (client.can_dock, client.followed, place.clients) == (False, frozenset(), 0)
    client.leave()
