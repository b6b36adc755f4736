"""The table of topics: it has every topic of a clone, and its policies agree with each other."""

from engine.container.monitor.node import NodeMonitorNode
from ppaas.clone.assembly import DEPTH_CAMERA, build_clone
from ppaas.costmap.build_layers import build_layers
from ppaas.nodes.diagnostics.node import DiagnosticsNode
from ppaas.nodes.explore.node import ExploreNode
from ppaas.nodes.follow_path.node import PathFollowingNode
from ppaas.nodes.granted_move_base.node import GrantedMoveBaseNode
from ppaas.nodes.graph import Graph
from ppaas.nodes.grid_slam.node import GridSlamNode
from ppaas.nodes.topics import CLIENT_TOPIC, TOPICS, policy_of
from ppaas.nodes.traffic.node import TrafficNode
from tests.support.world.planar_world import walled_map

CAMERAS = {DEPTH_CAMERA: {}, "octomap_server": {}}
PEOPLE = {"torso_detector": {}, "leg_detector": {}, "follow_person": {}}


def test_table_has_exactly_the_topics_of_a_clone() -> None:
    graph = Graph()
    layers = build_layers(walled_map(4, 3, []))
    build_clone(graph, layers, model="turtlebot2", initial_pose=(1.0, 1.0, 0.0), parameters=CAMERAS | PEOPLE)
    exploring = (*ExploreNode.publishes, *ExploreNode.subscribes)
    monitors = (*NodeMonitorNode.publishes, *DiagnosticsNode.publishes)
    following = (*PathFollowingNode.publishes, *PathFollowingNode.subscribes)
    traffic = (*GrantedMoveBaseNode.publishes, *GrantedMoveBaseNode.subscribes, *TrafficNode.publishes)
    others = {topic.name: topic for topic in (*monitors, *following, *GridSlamNode.publishes, *exploring, *traffic)}
    assert graph.topics | others == TOPICS


def test_goals_poses_and_results_must_arrive_and_sensor_data_may_be_dropped() -> None:
    must_arrive = {topic.name for topic in TOPICS.values() if not topic.stream}
    assert must_arrive >= {"camera/depth/camera_info", "initialpose", "move_base/goal", "move_base/cancel"}
    assert must_arrive >= {"move_base/result", "follow_waypoints/result", "speed_limit", "map"}
    assert must_arrive.isdisjoint({"scan", "odom", "tf", "tf_static", "cmd_vel", "move_base/status", "people"})


def test_topics_published_once_are_lasting() -> None:
    assert {topic.name for topic in TOPICS.values() if topic.lasting} == {
        "move_base/result", "follow_waypoints/result", "spin/result", "backup/result", "wait/result",
        "navigate_through_poses/result", "explore/result", "map", "map_updates", "tf_static",
        "follow_path/goal",
    }  # fmt: skip
    assert all(topic.lasting for topic in TOPICS.values() if topic.published_once)


def test_goals_and_cancels_of_every_action_have_many_publishers() -> None:
    of_robots = {"follow_path/goal", "follow_path/cancel"}
    actions = {name for name in TOPICS if name.endswith(("/goal", "/cancel"))} - of_robots
    assert {topic.name for topic in TOPICS.values() if topic.many_publishers} == actions | {"tf", "tf_static"}


def test_a_topic_of_a_client_has_the_default_policy() -> None:
    policy = policy_of("chatter")
    assert policy is CLIENT_TOPIC
    assert not any((policy.latched, policy.stream, policy.lasting, policy.robot_only, policy.shared, policy.local))
