"""Listener of tf."""

import math

import pytest

from engine.container.monitor.node import NodeMonitorNode
from ppaas.clone.assembly import DEPTH_CAMERA, LASER_PROC, build_clone
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import TransformError
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Quaternion, Transform, TransformStamped, Vector3
from ppaas.messages.tf2_msgs import MAX_FRAMES, TFMessage
from ppaas.nodes.diagnostics.node import DiagnosticsNode
from ppaas.nodes.explore.node import ExploreNode
from ppaas.nodes.follow_path.node import PathFollowingNode
from ppaas.nodes.footprint.node import FootprintNode
from ppaas.nodes.frames import FrameListener
from ppaas.nodes.granted_move_base.node import GrantedMoveBaseNode
from ppaas.nodes.graph import Graph
from ppaas.nodes.grid_slam.node import GridSlamNode
from ppaas.nodes.topics import CLIENT_TOPIC, TOPICS, policy_of
from ppaas.nodes.traffic.node import TrafficNode
from ppaas.transforms.planar import transform_message
from tests.support.world.planar_world import walled_map


def test_silence_counts_from_the_arrival_not_from_the_stamp():
    frames = FrameListener()
    assert frames.silence("base_link", 5.0) == math.inf
    frames.hear("tf", TFMessage([transform_message("odom", "base_link", Pose2D(0, 0, 0), Time(10**9))]), 10.0)
    assert frames.silence("base_link", 12.5) == 2.5


def test_tilted_frame_is_skipped_and_others_are_taken():
    frames = FrameListener()
    camera = TransformStamped(
        Header(frame_id="base_link"), "camera", Transform(Vector3(), Quaternion(x=-0.5, y=0.5, z=-0.5, w=0.5))
    )
    frames.hear("tf", TFMessage([camera, transform_message("odom", "base_link", Pose2D(1, 0, 0), Time(1))]), 0.0)
    assert frames.tree.frames() == ("base_link", "odom")


def test_invalid_transform_is_refused():
    broken = transform_message("odom", "base_link", Pose2D(math.nan, 0, 0), Time(1))
    with pytest.raises(TransformError):
        FrameListener().hear("tf", TFMessage([broken]), 0.0)


def test_a_sensor_that_moves_on_the_robot_is_where_it_is_only_while_its_transform_comes():
    frames = FrameListener()

    def hear(parent: str, child: str, x: float, now: float, topic: str = "tf") -> None:
        frames.hear(topic, TFMessage([transform_message(parent, child, Pose2D(x, 0.0), Time.of(now))]), now)

    hear("base_link", "mast", 0.1, 1.0)
    hear("mast", "laser", 0.2, 1.0, "tf_static")
    assert frames.mount("laser", 99.0).x == pytest.approx(0.3), "it was published once, and does not move"
    hear("base_link", "mast", 0.3, 100.0)
    assert frames.mount("laser", 109.0).x == pytest.approx(0.5)
    with pytest.raises(TransformError, match="frame 'mast' moves on the robot"):
        frames.mount("laser", 111.0)
    hear("base_link", "mast", 0.3, 111.0)
    assert frames.mount("laser", 112.0).x == pytest.approx(0.5)
    hear("odom", "base_link", 1.0, 1.0)
    hear("odom", "base_link", 2.0, 2.0)
    assert frames.mount("laser", 112.0).x == pytest.approx(0.5), "the robot itself moves in another frame"


def test_names_of_frames_are_bounded_and_those_that_drive_the_robot_always_count():
    frames = FrameListener()

    def hear(parent: str, child: str, now: float) -> None:
        frames.hear("tf", TFMessage([transform_message(parent, child, Pose2D(0.1, 0), Time.of(now))]), now)

    for number in range(MAX_FRAMES):
        hear("map", f"box_{number}", 1.0)
    with pytest.raises(
        TransformError, match=f"'box_{MAX_FRAMES}' is left out: a robot has at most {MAX_FRAMES} frames"
    ):
        hear("map", f"box_{MAX_FRAMES}", 1.0)
    assert len(frames.tree.frames()) == MAX_FRAMES + 1
    hear("map", "box_7", 5.0)
    assert frames.silence("box_7", 6.0) == 1.0
    hear("odom", "base_link", 2.0)
    assert frames.odometry_silence(3.0) == 1.0 and frames.odometry().x == pytest.approx(0.1)


CAMERAS = {DEPTH_CAMERA: {}, "octomap_server": {}, LASER_PROC: {}}
PEOPLE = {"torso_detector": {}, "leg_detector": {}, "follow_person": {}}


def test_table_has_exactly_the_topics_of_a_clone() -> None:
    graph = Graph()
    layers = build_layers(walled_map(4, 3, []))
    build_clone(graph, layers, model="turtlebot2", initial_pose=(1.0, 1.0, 0.0), parameters=CAMERAS | PEOPLE)
    exploring = (*ExploreNode.publishes, *ExploreNode.subscribes)
    monitors = (*NodeMonitorNode.publishes, *DiagnosticsNode.publishes, *FootprintNode.subscribes)
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
        "navigate_through_poses/result", "compute_and_track_route/result", "controller_server/follow_path/result",
        "follow_object/result", "drive_on_heading/result", "dock_robot/result", "undock_robot/result",
        "explore/result", "map", "map_updates", "tf_static", "follow_path/goal", "stop/state", "lift",
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
