"""What a container reports of its robot."""

import json
from typing import Any

import pytest

from engine.container.robot_report import BATTERY, BATTERY_AGE, CONFIRM, EXPLORING_AGE, MOST_TEXT, RobotReporter
from engine.sessions.host import SessionHost
from engine.specs.robot_report import StateReport
from ppaas.clock import ManualClock
from ppaas.messages.actionlib_msgs import GoalID, GoalStatus, GoalStatusArray, Status
from ppaas.messages.base.std_msgs import Header, String
from ppaas.messages.explore_msgs import ExploreActionFeedback, ExploreFeedback
from ppaas.messages.geometry_msgs import Point, Pose, PoseWithCovariance, PoseWithCovarianceStamped, Quaternion
from ppaas.messages.move_base_msgs import MoveBaseActionResult
from ppaas.nodes import topics
from ppaas.nodes.base import Node
from ppaas.nodes.graph import Graph
from ppaas.nodes.nav2_actions import DOCK_ROBOT, EXPLORE
from tests.support.endpoints.still_place import StillPlace

HEARD = (
    topics.AMCL_POSE, topics.AMCL_STATUS, topics.MOVE_BASE_STATUS, topics.MOVE_BASE_RESULT, topics.PLAN,
    EXPLORE.feedback, DOCK_ROBOT.status, topics.DOCK_STATUS,
)  # fmt: skip


class Publisher(Node):
    """Node with topics of Move Base and of localization."""

    name = "publisher"
    publishes = HEARD


class Scene:
    """A reporter with its graph, its clock, and the place of its robot."""

    def __init__(self) -> None:
        self.clock, self.place = ManualClock(100.0), StillPlace()
        self.graph = Graph(clock=self.clock, stamp_clock=lambda: 1000.0 + self.clock())
        self.graph.add(Publisher)
        self.sessions = SessionHost(self.place)
        self.ended: list[Status] = []
        self.reporter = RobotReporter(self.graph, self.sessions, self.ended.append)

    def goal(self, status: int, text: str = "") -> None:
        """Publish the status of the goal."""
        listed = [GoalStatus(GoalID(id="g"), status, text)]
        self.graph.inject(topics.MOVE_BASE_STATUS.name, GoalStatusArray(status_list=listed))

    def charge(self, state: Any) -> None:
        """Publish the state of the battery as the client of the robot."""
        self.place.client_topics.advertise(BATTERY, "sensor_msgs/BatteryState", (1, None), latch=False)
        self.place.publish(BATTERY, json.dumps(state).encode(), 1, must_arrive=False)

    def button(self, *states: Any, kind: str = "std_msgs/Bool") -> None:
        """Publish states of the button as the client of the robot."""
        self.place.client_topics.advertise(CONFIRM, kind, (1, None), latch=False)
        for state in states:
            self.place.publish(CONFIRM, json.dumps({"data": state}).encode(), 1, must_arrive=False)

    @property
    def now(self) -> StateReport:
        """The report now."""
        return self.reporter.report()


@pytest.fixture
def scene() -> Scene:
    return Scene()


def pose(x: float) -> PoseWithCovarianceStamped:
    where = Pose(Point(x, 2.0), Quaternion(x=0.0, y=0.0, z=0.0, w=1.0))
    return PoseWithCovarianceStamped(Header(frame_id="map"), PoseWithCovariance(where))


def test_nothing_is_reported_before_anything_is_known(scene: Scene) -> None:
    assert scene.now == StateReport()


def test_the_last_pose_is_reported_with_its_time(scene: Scene) -> None:
    scene.graph.inject(topics.AMCL_POSE.name, pose(1.0))
    assert (scene.now.pose, scene.now.pose_at) == ((1.0, 2.0, 0.0), 1100.0)
    scene.clock.advance(2.0)
    scene.graph.inject(topics.AMCL_POSE.name, pose(float("nan")))
    assert (scene.now.pose, scene.now.pose_at) == ((1.0, 2.0, 0.0), 1100.0)


def test_the_last_goal_is_reported_until_another_comes(scene: Scene) -> None:
    scene.goal(Status.ACTIVE, "x" * 2 * MOST_TEXT)
    assert (scene.now.goal, len(scene.now.goal_text)) == (Status.ACTIVE, MOST_TEXT)
    scene.graph.inject(topics.MOVE_BASE_STATUS.name, GoalStatusArray())
    assert scene.now.goal == Status.ACTIVE
    scene.goal(42)
    assert scene.now.goal == Status.ACTIVE
    failed = GoalStatus(GoalID(id="g"), Status.ABORTED, "no way")
    scene.graph.inject(topics.MOVE_BASE_RESULT.name, MoveBaseActionResult(header=Header(), status=failed))
    assert (scene.now.goal, scene.now.goal_text) == (Status.ABORTED, "no way")


def test_why_a_pose_is_not_renewed_is_reported(scene: Scene) -> None:
    scene.graph.inject(topics.AMCL_STATUS.name, String("scans are refused"))
    assert scene.now.localization == "scans are refused"


def test_frontiers_are_reported_while_the_robot_explores(scene: Scene) -> None:
    status = GoalStatus(GoalID(id="g"), Status.ACTIVE)
    feedback = ExploreActionFeedback(header=Header(), status=status, feedback=ExploreFeedback(frontiers=3))
    scene.graph.inject(EXPLORE.feedback.name, feedback)
    assert scene.now.frontiers == 3
    scene.clock.advance(EXPLORING_AGE + 0.1)
    assert scene.now.frontiers is None


def test_docking_is_reported_and_not_the_way_to_the_dock(scene: Scene) -> None:
    docking = GoalStatusArray(status_list=[GoalStatus(GoalID(id="d"), Status.ACTIVE, "driving to the dock")])
    scene.graph.inject(DOCK_ROBOT.status.name, docking)
    part = GoalStatus(GoalID(id="docking/1"), Status.SUCCEEDED, "Goal reached.")
    scene.graph.inject(topics.MOVE_BASE_STATUS.name, GoalStatusArray(status_list=[part]))
    scene.graph.inject(topics.MOVE_BASE_RESULT.name, MoveBaseActionResult(header=Header(), status=part))
    assert (scene.now.goal, scene.now.goal_text) == (Status.ACTIVE, "driving to the dock")
    failed = GoalStatusArray(status_list=[GoalStatus(GoalID(id="d"), Status.ABORTED, "its battery is not charged")])
    scene.graph.inject(DOCK_ROBOT.status.name, failed)
    assert (scene.now.goal, scene.now.goal_text) == (Status.ABORTED, "its battery is not charged")
    scene.graph.inject(topics.DOCK_STATUS.name, String("docked at dock 'a'"))
    assert (scene.now.docked, scene.now.localization) == ("docked at dock 'a'", "")


def test_the_charge_of_the_battery_is_reported_as_long_as_it_is_fresh(scene: Scene) -> None:
    scene.charge({"percentage": 0.8, "voltage": 12.1})
    assert scene.now.battery == 0.8
    scene.clock.advance(BATTERY_AGE + 0.1)
    assert scene.now.battery is None


@pytest.mark.parametrize("state", [{"percentage": 80}, {"percentage": None}, {"percentage": "full"}, {"voltage": 12.1}])
def test_a_charge_that_is_no_share_is_not_known(scene: Scene, state: dict[str, Any]) -> None:
    scene.charge({"percentage": 0.8})
    scene.charge(state)
    assert scene.now.battery is None


def test_presses_of_the_button_are_counted_and_a_long_one_once(scene: Scene) -> None:
    scene.button(False, True, True, True)
    assert scene.now.confirmations == 1
    scene.button(False, True)
    assert scene.now.confirmations == 2
    scene.clock.advance(5.0)
    scene.button(True)  # a button that sends nothing when it is let go
    assert scene.now.confirmations == 3


def test_a_button_of_another_type_confirms_nothing(scene: Scene) -> None:
    scene.button("true", kind="std_msgs/String")
    assert scene.now.confirmations == 0


def test_ends_of_goals_that_the_master_does_not_follow_are_passed_on(scene: Scene) -> None:
    for name, status in (("mine", 3), ("rest-1", 3), ("task-1-0-0", 4), ("mine", 1), ("mine", 42), ("", 4)):
        result = MoveBaseActionResult(Header(), GoalStatus(GoalID(id=name), status, ""))
        scene.graph.inject(topics.MOVE_BASE_RESULT.name, result)
    assert scene.ended == [Status.SUCCEEDED, Status.ABORTED]
