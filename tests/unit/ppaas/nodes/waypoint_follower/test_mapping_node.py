"""Waypoints of a robot that makes its map."""

import pytest

from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, GoalStatus, Status
from ppaas.messages.base.message import Empty
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.move_base_msgs import MoveBaseActionResult
from ppaas.messages.nav_msgs import Path
from ppaas.nodes.graph import Graph
from ppaas.nodes.waypoint_follower.node import MappingWaypointFollowerNode, WaypointFollowerParameters
from tests.support.world.touring import waypoints

A, B = Pose2D(1.0, 1.0, 0.0), Pose2D(9.0, 1.0, 0.0)


def key_frames(*poses: Pose2D) -> Path:
    return Path(Header(), [PoseStamped(Header(stamp=Time.of(float(i))), Pose.of(pose)) for i, pose in enumerate(poses)])


@pytest.fixture
def tour():
    """Return a graph with a follower that drives to A and then to B, and the targets that it has sent."""
    graph, sent = Graph(), []
    graph.add(lambda context: MappingWaypointFollowerNode(context, WaypointFollowerParameters()))
    graph.tap("move_base/goal", lambda _, message: sent.append(message))
    graph.inject("key_frames", key_frames(Pose2D(0.0, 0.0), Pose2D(10.0, 0.0)))
    graph.inject("follow_waypoints/goal", waypoints([A, B]))
    return graph, sent


def reach(graph: Graph, goal_id: str) -> None:
    status = GoalStatus(GoalID(id=goal_id), Status.SUCCEEDED)
    graph.inject("move_base/result", MoveBaseActionResult(Header(), status, Empty()))


def target(message) -> Pose2D:
    return message.goal.target_pose.pose.planar()


def test_waypoints_move_with_the_key_frames_nearest_to_them(tour):
    graph, sent = tour
    graph.inject("key_frames", key_frames(Pose2D(0.0, 0.0), Pose2D(10.0, 0.5), Pose2D(11.0, 0.5)))
    assert len(sent) == 1
    reach(graph, sent[0].goal_id.id)
    assert [target(message) for message in sent] == [A, pytest.approx(Pose2D(9.0, 1.5, 0.0))]


def test_waypoints_stay_in_a_map_that_was_cleared(tour):
    graph, sent = tour
    graph.inject("key_frames", key_frames())
    graph.inject("key_frames", key_frames(Pose2D(5.0, 5.0)))
    reach(graph, sent[0].goal_id.id)
    assert target(sent[1]) == B
