"""Node ``follow_person``: alone with messages that the test makes."""

import math

import pytest

from ppaas.clock import ManualClock
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, GoalStatus, GoalStatusArray, Status
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point, Pose, PoseStamped, PoseWithCovariance
from ppaas.messages.move_base_msgs import MoveBaseActionGoal, MoveBaseActionResult, MoveBaseGoal
from ppaas.messages.people_coordination import (
    FOLLOWING,
    GAVE_UP,
    IDLE,
    LOST,
    PAUSED,
    SEARCHING,
    SEEN,
    WAITING,
    FollowOrder,
    FollowStatus,
    GoalUpdate,
    PeopleReport,
    PeopleState,
    SensorView,
    TrackedPerson,
)
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.navigation.goal_watch import SETTLED
from ppaas.nodes.follow_person.node import SILENCE, FollowPersonNode
from ppaas.nodes.graph import Graph
from ppaas.people.following.parameters import FollowParameters
from ppaas.transforms.planar import transform_message
from tests.support.world.planar_world import walled_map

LAYERS = build_layers(walled_map(12, 6, []))
ROBOT = Pose2D(2.0, 3.0)


class Alone:
    """The node alone: the test moves the robot, and is its coordinator and Move Base."""

    def __init__(self, **parameters: float) -> None:
        self.clock = ManualClock(1000.0)
        self.graph = Graph(clock=self.clock, stamp_clock=self.clock)
        read = FollowParameters(**parameters)
        self.node = self.graph.add(lambda context: FollowPersonNode(context, read, "r1", LAYERS))
        self.goals: list[MoveBaseActionGoal] = []
        self.updates: list[GoalUpdate] = []
        self.cancels: list[str] = []
        self.statuses: list[FollowStatus] = []
        self.graph.tap("move_base/goal", lambda _, message: self.goals.append(message))
        self.graph.tap("move_base/goal_update", lambda _, message: self.updates.append(message))
        self.graph.tap("follow_person/status", lambda _, message: self.statuses.append(message))
        self.graph.tap("move_base/cancel", lambda _, message: self.cancels.append(message.id))
        self.order: FollowOrder | None = FollowOrder("r1", 7, 1.0, Time(5, 0))
        self.people = [person(6.0)]
        self.silent = False
        self.clients: list[str] = []

    def place(self, pose: Pose2D = ROBOT) -> None:
        now = Time.of(self.clock())
        parts = (("map", "odom", Pose2D(0.0, 0.0)), ("odom", "base_link", pose))
        self.graph.inject("tf", TFMessage([transform_message(*part, now) for part in parts]))

    def coordinate(self) -> None:
        orders = [FollowOrder("r2", 9, 1.0, Time(5, 0)), *([self.order] if self.order else [])]
        self.graph.inject("people_coordinator/state", PeopleState(Header(), 1, list(self.people), orders))

    def report(self, topic: str = "move_base/status") -> None:
        """Report the goals of Move Base: that of the node, and those of clients."""
        active = [*([self.goal_id] if self.goals else []), *self.clients]
        array = [GoalStatus(GoalID(id=name), int(Status.ACTIVE)) for name in active]
        self.graph.inject(topic, GoalStatusArray(Header(), array))

    def wait(self, seconds: float) -> None:
        for _ in range(round(seconds / 0.25)):
            self.clock.advance(0.25)
            if not self.silent:
                self.coordinate()
            self.graph.run_due()

    def end(self, status: Status, text: str = "") -> None:
        """End the last goal of Move Base."""
        ended = GoalStatus(GoalID(id=self.goal_id), int(status), text)
        self.graph.inject("move_base/result", MoveBaseActionResult(Header(), ended))

    @property
    def goal_id(self) -> str:
        return self.goals[-1].goal_id.id

    @property
    def target(self) -> Pose2D:
        return self.goals[-1].goal.target_pose.pose.planar()

    @property
    def status(self) -> FollowStatus:
        return self.statuses[-1]


def person(x: float, vx: float = 0.0, y: float = 3.0, state: str = SEEN) -> TrackedPerson:
    return TrackedPerson(7, Point(x, y), Point(vx, 0.0), [0.0] * 4, state=state)


def following(**parameters: float) -> Alone:
    alone = Alone(**parameters)
    alone.place()
    alone.report()
    alone.wait(1.0)
    return alone


# -- orders and goals --------------------------------------------------------------------------------------------------


def test_robot_is_sent_near_the_person_of_its_order():
    alone = following()
    assert len(alone.goals) == 1 and alone.target == pytest.approx((4.8, 3.0, 0.0))
    assert (alone.status.state, alone.status.person, alone.status.following) == (FOLLOWING, 7, 7)
    assert alone.status.distance == pytest.approx(4.0) and alone.status.can_follow
    assert alone.node.busy


def test_robot_without_an_order_is_idle():
    alone = Alone()
    alone.order = None
    alone.place()
    alone.report()
    alone.wait(1.0)
    assert not alone.goals and not alone.node.busy
    assert (alone.status.state, alone.status.following, alone.status.can_follow) == (IDLE, 0, True)


def test_goal_moves_with_the_person_and_with_it_its_speed():
    alone = following()
    alone.people = [person(6.5, 0.5)]
    alone.wait(0.5)
    assert len(alone.goals) == 1 and not alone.cancels
    assert alone.updates[-1].goal_id == alone.goal_id
    assert alone.updates[-1].target_pose.pose.position.x > 5.0
    assert alone.updates[-1].speed_limit == 0.0, "the person is far away"
    sent = len(alone.updates)
    alone.people = [person(6.5, 0.5)]
    alone.wait(1.0)
    assert len(alone.updates) <= sent + 1, "a goal that stays is not sent again"


def test_end_of_the_order_cancels_the_goal():
    alone = following()
    alone.order = None
    alone.wait(0.5)
    assert alone.cancels == [alone.goal_id]
    assert alone.status.state == IDLE and not alone.node.busy


def test_order_to_follow_another_person_is_taken_at_once():
    alone = following()
    alone.order = FollowOrder("r1", 8, 1.0, Time(9, 0))
    alone.people += [TrackedPerson(8, Point(2.0, 5.0), Point(0.0, 0.0), [0.0] * 4)]
    alone.wait(1.0)
    assert alone.status.person == 8
    assert len(alone.goals) == 1 and alone.updates[-1].target_pose.pose.position.y > 3.2


def test_reached_goal_is_followed_by_another_when_the_person_walks_on():
    alone = following()
    alone.place(Pose2D(4.8, 3.0))
    alone.end(Status.SUCCEEDED)
    alone.wait(1.0)
    assert len(alone.goals) == 1 and alone.status.state == WAITING
    alone.people = [person(7.5)]
    alone.wait(1.0)
    assert len(alone.goals) == 2 and alone.goals[0].goal_id.id != alone.goal_id


def test_person_who_cannot_be_reached_is_given_up_and_reported():
    alone = following()
    for _ in range(4):
        alone.end(Status.ABORTED, "Failed to find a valid plan.")
        alone.wait(1.0)
    assert (alone.status.state, alone.status.gave_up, alone.status.following) == (GAVE_UP, 7, 0)
    assert "Failed to find a valid plan." in alone.status.reason
    alone.order = FollowOrder("r1", 7, 1.0, Time(20, 0))
    alone.wait(1.0)
    assert alone.status.state == FOLLOWING, "a new order is a new try"


def test_robot_stands_when_the_coordinator_is_silent_and_goes_on_when_it_is_back():
    alone = following()
    alone.silent = True
    alone.wait(SILENCE + 1.0)
    assert alone.cancels == [alone.goal_id] and alone.status.state == WAITING
    assert alone.status.reason.startswith("the coordinator has sent nothing for")
    alone.silent = False
    alone.wait(1.0)
    assert alone.status.state == FOLLOWING


def test_robot_without_a_pose_stands():
    alone = Alone()
    alone.report()
    alone.wait(1.0)
    assert not alone.goals and alone.status.reason.startswith("the pose of the robot is unknown")


def test_non_finite_people_are_refused_and_following_goes_on():
    alone = following()
    alone.people = [person(math.nan)]
    with pytest.raises(InvalidInput, match="person 7"):
        alone.coordinate()
    alone.people = [person(6.0)]
    alone.wait(1.0)
    assert alone.status.state == FOLLOWING


def test_search_uses_the_views_that_the_tracker_reports():
    alone = following(hidden_patience=0.5)
    views = [SensorView(0.0, 0.0, 0.0, 2.0 * math.pi, 0.0, 8.0)]
    alone.graph.inject(
        "people_tracker/report", PeopleReport(Header(), "r1", PoseWithCovariance(Pose.of(ROBOT)), [], views)
    )
    alone.people = [person(6.0, state=LOST)]
    alone.wait(2.0)
    assert SEARCHING not in [status.state for status in alone.statuses]
    assert alone.status.gave_up == 7, "the whole hall is in view"


# -- clients -----------------------------------------------------------------------------------------------------------


def test_nothing_is_sent_before_move_base_has_reported():
    alone = Alone()
    alone.place()
    alone.wait(2.0)
    assert not alone.goals and alone.status.state == PAUSED


@pytest.mark.parametrize("topic", ["move_base/status", "follow_waypoints/status", "spin/status"])
def test_goals_of_clients_pause_following(topic):
    alone = following(resume_delay=2.0)
    alone.clients = ["rviz"]
    alone.end(Status.PREEMPTED, "Replaced by another goal: rviz")
    alone.report(topic)
    alone.wait(4.0)
    assert len(alone.goals) == 1 and (alone.status.state, alone.status.following) == (PAUSED, 0)
    assert not alone.status.can_follow
    alone.clients = []
    alone.graph.inject(topic, GoalStatusArray())
    alone.wait(1.0)
    assert len(alone.goals) == 1
    alone.wait(2.0)
    assert len(alone.goals) == 2 and alone.status.state == FOLLOWING


def test_goal_of_a_client_counts_before_it_is_in_the_status_list():
    alone = following()
    alone.place(Pose2D(4.8, 3.0))
    alone.end(Status.SUCCEEDED)
    alone.wait(0.5)
    alone.graph.inject("move_base_simple/goal", PoseStamped(Header(frame_id="map"), Pose.of(ROBOT)))
    alone.people = [person(9.0)]
    alone.wait(1.5)
    assert len(alone.goals) == 1 and alone.status.state == PAUSED


@pytest.mark.parametrize("cancel", ["all", "own"])
def test_client_that_cancels_the_goal_pauses_following_for_longer(cancel):
    alone = following(cancel_pause=10.0)
    alone.graph.inject("move_base/cancel", GoalID(id=alone.goal_id if cancel == "own" else ""))
    alone.end(Status.PREEMPTED, "The goal was cancelled.")
    alone.wait(9.0)
    assert len(alone.goals) == 1 and alone.status.state == PAUSED and not alone.status.can_follow
    alone.wait(3.0)
    assert len(alone.goals) == 2


def test_cancel_of_a_goal_of_a_client_does_not_pause_following():
    alone = following()
    alone.graph.inject("move_base/cancel", GoalID(id="rviz"))
    alone.wait(1.0)
    assert alone.status.state == FOLLOWING


def test_goal_that_move_base_does_not_know_is_sent_again():
    alone = following()
    alone.wait(SETTLED - 1.0)
    assert len(alone.goals) == 1
    alone.wait(2.0)
    assert len(alone.goals) == 2


def test_own_goals_are_not_those_of_a_client():
    alone = following()
    goal = MoveBaseActionGoal(MoveBaseGoal(PoseStamped(Header(), Pose.of(ROBOT))), GoalID(id="follow_person/99"))
    alone.graph.inject("move_base/goal", goal)
    alone.wait(1.0)
    assert alone.status.state == FOLLOWING


def test_goal_from_before_a_restart_is_cancelled_since_its_order_may_be_gone():
    alone = Alone()
    alone.order, alone.clients = None, ["follow_person/3-1000.000", "rviz"]
    alone.place()
    alone.report()
    alone.report()
    assert alone.cancels == ["follow_person/3-1000.000"]


# -- checkpoints and maps ----------------------------------------------------------------------------------------------


def test_checkpoint_keeps_the_pause_the_order_that_was_given_up_and_the_ids():
    alone = following(cancel_pause=10.0)
    alone.graph.inject("move_base/cancel", GoalID())
    for _ in range(4):
        alone.node._following.failed("no plan")
    state = alone.node.checkpoint()
    other = Alone()
    other.node.restore(state)
    other.place()
    other.report()
    other.wait(2.0)
    assert other.status.state == PAUSED
    other.wait(10.0)
    assert other.status.state == GAVE_UP
    other.order = FollowOrder("r1", 7, 1.0, Time(30, 0))
    other.wait(1.0)
    assert other.goal_id.startswith("follow_person/2-")


def test_on_another_map_the_counter_alone_is_kept():
    alone = following(cancel_pause=10.0)
    alone.graph.inject("move_base/cancel", GoalID())
    other = Alone()
    other.node.carry_over(alone.node.checkpoint())
    other.place()
    other.report()
    other.wait(1.0)
    assert other.status.state != PAUSED
    assert other.goal_id.startswith("follow_person/2-")


def test_places_are_those_of_a_map_that_replaces_another():
    alone = following()
    alone.node.use_layers(build_layers(walled_map(12, 6, [(4.2, 2.0, 5.4, 4.0)])))
    alone.wait(1.0)
    place = alone.updates[-1].target_pose.pose.position
    assert not (4.2 < place.x < 5.4 and 2.0 < place.y < 4.0)


def test_person_who_was_not_found_is_followed_again_after_a_restart_when_seen():
    alone = following(hidden_patience=0.5, search_timeout=1.0)
    alone.people = [person(6.0, state=LOST)]
    alone.wait(3.0)
    assert alone.status.state == GAVE_UP
    other = Alone()
    other.node.restore(alone.node.checkpoint())
    other.place()
    other.report()
    other.wait(1.0)
    assert other.status.state == FOLLOWING


def test_client_that_cancels_its_own_goal_lets_following_go_on():
    alone = following(resume_delay=1.0)
    alone.clients = ["rviz"]
    alone.end(Status.PREEMPTED, "Replaced by another goal: rviz")
    alone.report()
    alone.wait(1.0)
    alone.graph.inject("move_base/cancel", GoalID())
    alone.clients = []
    alone.graph.inject("move_base/status", GoalStatusArray())
    alone.wait(4.0)
    assert alone.status.state == FOLLOWING
