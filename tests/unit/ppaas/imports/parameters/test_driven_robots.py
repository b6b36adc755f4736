"""Robots with translated files map and drive in the simulator."""

from pathlib import Path

import pytest

from ppaas.geometry import Pose2D
from ppaas.imports.parameters.clone_check import refusal
from ppaas.imports.parameters.draft import Translation, robot_file
from ppaas.imports.parameters.ros1.importing import import_ros1_files
from ppaas.imports.parameters.slam.cartographer import import_cartographer
from ppaas.imports.parameters.slam.gmapping import import_gmapping
from ppaas.imports.parameters.slam.slam_toolbox import import_slam_toolbox
from ppaas.messages.actionlib_msgs import Status
from tests.support.imported_parameters import refused
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.exploring_loop import ExploringLoop
from tests.support.world.planar_world import World, walled_map

SLAM_TOOLBOX = b"""
slam_toolbox:
  ros__parameters:
    base_frame: base_footprint
    resolution: 0.05
    max_laser_range: 20.0
    minimum_time_interval: 0.5
    minimum_travel_distance: 0.5
    minimum_travel_heading: 0.5
    loop_match_minimum_chain_size: 10
    loop_match_minimum_response_coarse: 0.35
    loop_search_space_smear_deviation: 0.03
    loop_search_maximum_distance: 3.0
    correlation_search_space_resolution: 0.01
"""

GMAPPING = b"{maxUrange: 3.5, linearUpdate: 1.0, angularUpdate: 0.2, temporalUpdate: 3.0, delta: 0.05, particles: 30}"

CARTOGRAPHER = b"""
options = { map_frame = "map", published_frame = "odom", submap_publish_period_sec = 0.3 }
TRAJECTORY_BUILDER_2D.max_range = 3.5
TRAJECTORY_BUILDER_2D.motion_filter.max_angle_radians = math.rad(0.1)
"""

MOVE_BASE = b"""
base_local_planner: teb_local_planner/TebLocalPlannerROS
base_global_planner: global_planner/GlobalPlanner
controller_frequency: 10.0
footprint: [[-0.15, -0.12], [-0.15, 0.12], [0.15, 0.12], [0.15, -0.12]]
inflation_radius: 0.4
GlobalPlanner: {use_dijkstra: false}
TebLocalPlannerROS: {max_vel_x: 0.4, max_vel_x_backwards: 0.2, acc_lim_x: 0.5, acc_lim_theta: 0.5, max_vel_theta: 0.8}
amcl: {min_particles: 500, max_particles: 3000, odom_alpha1: 0.1, base_frame_id: base_footprint}
"""


def rooms() -> World:
    return World(walled_map(5, 4, [(2.4, 0.0, 2.6, 2.4)]), Pose2D(1.0, 1.0, 0.0), range_max=4.0)


def driven(translations: list[Translation], *, maps: bool) -> ClosedLoop:
    """Return a loop with a clone of the robot file that translations make, without a part that was refused."""
    assert [refused(each) for each in translations] == [[]] * len(translations)
    file = robot_file(translations, {} if maps else {"map": "rooms"}, refusal)
    assert file.pop("map").startswith("new:") is maps
    return ClosedLoop(rooms(), maps=maps, **file)


def explores(translation: Translation) -> None:
    exploring = ExploringLoop(driven([translation], maps=True))
    exploring.send()
    exploring.run(150.0)
    assert exploring.outcome[0] == Status.SUCCEEDED, exploring.texts
    assert exploring.results[-1].result.area > 0.85 * 20.0
    assert exploring.driving.clearance > 0.18


@pytest.mark.parametrize(
    "translation",
    [
        pytest.param(import_slam_toolbox(SLAM_TOOLBOX, "slam.yaml"), id="slam_toolbox"),
        pytest.param(import_gmapping(GMAPPING, "gmapping.yaml"), id="gmapping"),
        pytest.param(import_cartographer(CARTOGRAPHER, "robot.lua"), id="cartographer"),
    ],
)
def test_a_robot_makes_a_map(translation: Translation) -> None:
    explores(translation)


def test_the_robot_of_turtlebot_4_makes_a_map(data: Path) -> None:
    explores(import_slam_toolbox((data / "foreign" / "tb4_slam.yaml").read_bytes(), "tb4_slam.yaml"))


def test_a_robot_drives_with_the_files_of_move_base() -> None:
    loop = driven(import_ros1_files([(MOVE_BASE, "robot.yaml")]), maps=False)
    loop.send_goal(Pose2D(4.0, 1.0, 1.57))
    loop.run(90.0)
    assert [result.status.status for result in loop.results] == [Status.SUCCEEDED]
    assert loop.clearance > 0.15
    assert loop.worst < 0.1


def test_a_robot_is_localized_on_a_map_with_the_file_of_slam_toolbox() -> None:
    content = SLAM_TOOLBOX + b"    mode: localization\n    map_start_pose: [1.0, 1.0, 0.0]\n"
    loop = driven([import_slam_toolbox(content, "slam.yaml")], maps=False)
    loop.send_goal(Pose2D(4.0, 1.0, 1.57))
    loop.run(90.0)
    assert [result.status.status for result in loop.results] == [Status.SUCCEEDED]
    assert loop.worst < 0.1
