"""Files of Nav2 become drafts of robot files, and each parameter has an entry in the report."""

import json
import math
from typing import Any

import pytest
import yaml

from ppaas.errors import InvalidParameter
from ppaas.imports.parameters.clone_check import refusal
from ppaas.imports.parameters.draft import robot_file
from ppaas.imports.parameters.nav2.importer import import_nav2
from ppaas.imports.report import ImportOutcome, ImportReport, ReportEntry
from robots.client.robot_file import parse_robot_file
from tests.support.sources import ROOT


def imported(text: str, **options: Any) -> tuple[dict[str, Any], ImportReport]:
    return import_nav2(text.encode(), "nav2.yaml", **options)


def entry(report: ImportReport, part: str) -> ReportEntry:
    (found,) = [each for each in report.entries if each.part == part]
    return found


CONTROLLER = """
controller_server:
  ros__parameters:
    controller_plugins: [FollowPath]
    goal_checker_plugins: [goals]
    goals: {{plugin: "nav2_controller::SimpleGoalChecker", xy_goal_tolerance: 0.3}}
    FollowPath:
{}
"""


def controller(*lines: str) -> str:
    return CONTROLLER.format("\n".join(f"      {line}" for line in lines))


@pytest.mark.parametrize(
    ("plugin", "speed", "ours"),
    [
        ("dwb_core::DWBLocalPlanner", "max_vel_x", "dwa"),
        ("nav2_mppi_controller::MPPIController", "vx_max", "mppi"),
        ("nav2_mppi_controller/MPPIController", "vx_max", "mppi"),
        ("nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController", "max_linear_vel", "pure_pursuit"),
        ("nav2_graceful_controller::GracefulController", "v_linear_max", "pure_pursuit"),
        ("vector_pursuit_controller::VectorPursuitController", "desired_linear_vel", "pure_pursuit"),
        ("teb_local_planner::TebLocalPlannerROS", "max_vel_x", "mppi"),
    ],
)
def test_controllers_become_ours_with_their_speed_and_tolerances(plugin: str, speed: str, ours: str) -> None:
    draft, report = imported(controller(f'plugin: "{plugin}"', f"{speed}: 0.4"))
    assert draft["base_local_planner"] == ours
    assert draft["parameters"] == {ours: {"xy_goal_tolerance": 0.3, "max_vel_x": 0.4}}
    assert not list(report.of(ImportOutcome.REFUSED))
    assert entry(report, "controller_server.FollowPath.plugin").line == 8


def test_a_shim_gives_its_primary_controller_before_and_since_kilted() -> None:
    shim = 'plugin: "nav2_rotation_shim_controller::RotationShimController"'
    rpp = "nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController"
    own = ("angular_dist_threshold: 0.6", "max_angular_accel: 2.0", "simulate_ahead_time: 1.0")
    flat, flat_report = imported(controller(shim, *own, f'primary_controller: "{rpp}"', "lookahead_dist: 0.7"))
    inner = ("primary_controller:", f'  plugin: "{rpp}"', "  lookahead_dist: 0.7")
    nested, nested_report = imported(controller(shim, *own, *inner))
    expected = {
        "xy_goal_tolerance": 0.3, "rotate_to_heading_min_angle": 0.6, "acc_lim_theta": 2.0, "lookahead_dist": 0.7,
    }  # fmt: skip
    assert flat == nested == {"base_local_planner": "pure_pursuit", "parameters": {"pure_pursuit": expected}}
    for report in (flat_report, nested_report):
        assert not list(report.of(ImportOutcome.REFUSED))


def test_what_the_graceful_controller_got_since_lyrical_is_known() -> None:
    names = ("footprint_scaling_linear_vel", "footprint_scaling_step", "obstacle_cost_margin")
    plugin = 'plugin: "nav2_graceful_controller::GracefulController"'
    _, report = imported(controller(plugin, *(f"{name}: 1" for name in names)))
    found = [entry(report, f"controller_server.FollowPath.{name}").outcome for name in names]
    assert found == [ImportOutcome.NO_EFFECT] * 3


def test_a_shim_without_a_controller_is_refused_for_this_reason() -> None:
    shim = 'plugin: "nav2_rotation_shim_controller/RotationShimController"'
    _, report = imported(controller(shim, "angular_dist_threshold: 0.6"))
    refused = entry(report, "controller_server.FollowPath.plugin")
    assert refused.outcome is ImportOutcome.REFUSED
    assert refused.text == "the shim needs a controller, primary_controller; the robot has the default one"


def test_an_unknown_controller_is_refused_and_its_parameters_have_no_effect() -> None:
    draft, report = imported(controller('plugin: "dwb_core::DWBLocalPlaner"', "max_vel_x: 0.4"))
    assert "base_local_planner" not in draft
    refused = entry(report, "controller_server.FollowPath.plugin")
    assert (refused.outcome, "did you mean dwb_core::DWBLocalPlanner?" in refused.text) == (ImportOutcome.REFUSED, True)
    assert entry(report, "controller_server.FollowPath.max_vel_x").outcome is ImportOutcome.NO_EFFECT


def test_a_distance_from_the_point_of_an_elastic_band_is_none_from_the_outline() -> None:
    band = 'plugin: "teb_local_planner::TebLocalPlannerROS"'
    draft, report = imported(
        controller(band, "max_vel_x: 0.4", "min_obstacle_dist: 0.5", "footprint_model.type: point")
    )
    assert draft["parameters"]["mppi"]["max_vel_x"] == 0.4
    assert "critical_distance" not in draft["parameters"]["mppi"]
    assert entry(report, "controller_server.FollowPath.footprint_model.type").outcome is ImportOutcome.NO_EFFECT


def test_a_typo_gets_the_nearest_name() -> None:
    _, report = imported(controller('plugin: "dwb_core::DWBLocalPlanner"', "max_val_x: 0.4", "BaseObstacle.scle: 1.0"))
    assert (
        entry(report, "controller_server.FollowPath.max_val_x").text == "unknown parameter; did you mean 'max_vel_x'?"
    )
    assert "BaseObstacle.scale" in entry(report, "controller_server.FollowPath.BaseObstacle.scle").text


def test_parts_that_a_section_lists_itself_have_no_effect() -> None:
    text = controller(
        'plugin: "dwb_core::DWBLocalPlanner"', "critics: [PathDist, MyCritic]", "MyCritic.scale: 3.0", "MyCritic.x: 1"
    )
    _, report = imported(text)
    for name in ("scale", "x"):
        assert entry(report, f"controller_server.FollowPath.MyCritic.{name}").text == "dwa has its own critics"


def test_only_one_controller_of_a_list_counts() -> None:
    _, report = imported(
        """
controller_server:
  ros__parameters:
    controller_plugins: [Fast, FollowPath]
    Fast: {plugin: "dwb_core::DWBLocalPlanner", max_vel_x: 2.0}
    FollowPath: {plugin: "dwb_core::DWBLocalPlanner", max_vel_x: 0.4}
"""
    )
    assert entry(report, "controller_server.Fast.max_vel_x").text == "one plug-in of the list counts: FollowPath"
    assert entry(report, "controller_server.FollowPath.max_vel_x").outcome is ImportOutcome.TAKEN


def test_sections_that_no_list_names_have_no_effect() -> None:
    _, report = imported(
        """
local_costmap:
  local_costmap:
    ros__parameters:
      plugins: [inflation_layer]
      inflation_layer: {plugin: "nav2_costmap_2d::InflationLayer", inflation_radius: 0.4}
      static_layer: {plugin: "nav2_costmap_2d::StaticLayer", map_topic: map}
"""
    )
    part = "local_costmap/local_costmap.static_layer.map_topic"
    assert entry(report, part).text == "no list of the node names the section static_layer"
    assert entry(report, "local_costmap/local_costmap.inflation_layer.inflation_radius").outcome is ImportOutcome.TAKEN


def test_costmaps_give_size_layers_and_ranges_of_the_laser() -> None:
    draft, report = imported(
        """
global_costmap:
  global_costmap:
    ros__parameters:
      footprint: "[[0.3, 0.2], [0.3, -0.2], [-0.3, -0.2], [-0.3, 0.2]]"
      robot_radius: 0.4
      track_unknown_space: true
local_costmap:
  local_costmap:
    ros__parameters:
      robot_radius: 0.5
      width: 5
      publish_frequency: 30.0
      plugins: [obstacles]
      obstacles:
        plugin: "nav2_costmap_2d::ObstacleLayer"
        observation_sources: lidar camera
        camera: {data_type: PointCloud2, obstacle_max_range: 9.0}
        lidar: {topic: /scan, obstacle_max_range: 4.0, raytrace_max_range: 3.0, marking: true}
"""
    )
    assert draft["parameters"] == {
        "local_costmap": {"width": 5.0, "publish_frequency": 10.0, "obstacle_range": 4.0, "raytrace_range": 3.0},
        "global_costmap": {"footprint": [[0.3, 0.2], [0.3, -0.2], [-0.3, -0.2], [-0.3, 0.2]]},
        "static_layer": {"track_unknown_space": True},
    }
    of_camera = entry(report, "local_costmap/local_costmap.obstacles.camera.obstacle_max_range")
    assert of_camera.outcome is ImportOutcome.NO_EFFECT
    of_global = entry(report, "global_costmap/global_costmap.robot_radius")
    assert (of_global.outcome, of_global.text) == (
        ImportOutcome.NO_EFFECT, "the footprint counts, since there is one",
    )  # fmt: skip
    assert "wins" in entry(report, "local_costmap/local_costmap.robot_radius").text


def test_planners_give_tolerance_and_time() -> None:
    draft, _ = imported(
        """
planner_server:
  ros__parameters:
    planner_plugins: [GridBased, Smooth]
    GridBased: {plugin: "nav2_smac_planner/SmacPlanner2D", tolerance: 0.2, max_planning_time: 3.0, allow_unknown: false}
    Smooth: {plugin: "nav2_smac_planner::SmacPlannerLattice", allow_reverse_expansion: true, tolerance: 0.1}
"""
    )
    assert draft == {
        "base_global_planner": "astar",
        "parameters": {
            "move_base": {"default_tolerance": 0.2, "planner_timeout": 3.0},
            "astar": {"allow_unknown": False},
            "lattice": {"motion_model_for_search": "REEDS_SHEPP", "tolerance": 0.1},
        },
    }


def test_a_namespace_is_chosen_and_wildcards_are_for_all() -> None:
    text = """
/**:
  ros__parameters: {use_sim_time: true, controller_frequency: 15.0, width: 4}
robot1/amcl:
  ros__parameters: {max_particles: 1000}
robot2:
  amcl:
    ros__parameters: {max_particles: 900}
  local_costmap:
    local_costmap:
      ros__parameters: {width: 6}
"""
    first, report = imported(text)
    assert first["parameters"]["amcl"] == {"max_particles": 1000}
    assert first["parameters"]["move_base"] == {"controller_frequency": 15.0}
    assert first["parameters"]["local_costmap"] == {"width": 4.0}
    assert "--namespace robot2" in entry(report, "robot2/amcl").text
    second, report = imported(text, namespace="robot2")
    assert second["parameters"]["local_costmap"] == {"width": 6.0}
    lost = entry(report, "/**.width")
    assert (lost.outcome, "wins" in lost.text) == (ImportOutcome.NO_EFFECT, True)


def test_nodes_within_costmaps_are_of_no_other_robot() -> None:
    _, report = imported(
        """
local_costmap:
  local_costmap:
    ros__parameters: {width: 3}
  local_costmap_client:
    ros__parameters: {use_sim_time: true}
"""
    )
    assert "within another one" in entry(report, "local_costmap/local_costmap_client").text


def test_values_that_a_launch_file_replaces_have_no_effect() -> None:
    draft, report = imported(
        """
amcl:
  ros__parameters:
    base_frame_id: "<robot_namespace>/base_link"
    odom_frame_id: $(var odom)
    min_particles: 300
"""
    )
    assert draft == {"parameters": {"amcl": {"min_particles": 300}}}
    assert "a launch file replaces '$(var odom)'" in entry(report, "amcl.odom_frame_id").text


def test_names_that_are_given_twice_are_reported() -> None:
    draft, report = imported("amcl:\n  ros__parameters:\n    max_beams: 30\n    max_beams: 40\n")
    assert draft["parameters"]["amcl"] == {"laser_max_beams": 40}
    assert [e.text for e in report.entries if e.part == "amcl.max_beams" and e.outcome is ImportOutcome.NO_EFFECT] == [
        "given before, too: that value has no effect, this one counts"
    ]


@pytest.mark.parametrize(
    ("node", "outcome", "words"),
    [
        ("controler_server", ImportOutcome.REFUSED, "did you mean controller_server?"),
        ("slam_toolbox", ImportOutcome.NO_EFFECT, "--slam-toolbox"),
        ("amcl_rclcpp_node", ImportOutcome.NO_EFFECT, "within another one"),
        ("coffee_machine", ImportOutcome.NO_EFFECT, "no node of Nav2"),
    ],
)
def test_other_nodes_are_reported(node: str, outcome: ImportOutcome, words: str) -> None:
    _, report = imported(f"{node}:\n  ros__parameters: {{strength: 3}}\n")
    found = entry(report, node)
    assert (found.outcome, words in found.text) == (outcome, True)


def test_docks_give_their_times_and_docks_themselves_are_zones() -> None:
    draft, report = imported(
        """
docking_server:
  ros__parameters:
    controller_frequency: 40.0
    wait_charge_timeout: 8.0
    dock_approach_timeout: 0.0
    max_retries: 5
    dock_plugins: [home]
    home: {plugin: "opennav_docking::SimpleChargingDock", docking_threshold: 0.05}
    docks: [first]
    first: {type: home, frame: map, pose: [1.0, 2.0, 0.0]}
"""
    )
    assert draft["parameters"]["docking_server"] == {
        "controller_frequency": 40.0, "wait_charge_timeout": 8.0, "max_retries": 5,
    }  # fmt: skip
    assert entry(report, "docking_server.dock_approach_timeout").outcome is ImportOutcome.REFUSED
    assert "dock_types" in entry(report, "docking_server.home.docking_threshold").text
    assert "zones of the map" in entry(report, "docking_server.first.pose").text
    assert refusal(draft) is None


def test_the_start_is_taken_if_it_is_set() -> None:
    pose = "initial_pose: {x: 1.0, y: 2.0, z: 0.0, yaw: 0.5}"
    draft, _ = imported(f"amcl:\n  ros__parameters:\n    set_initial_pose: true\n    {pose}\n")
    assert draft == {"initial_pose": [1.0, 2.0, 0.5]}
    draft, report = imported(f"amcl:\n  ros__parameters:\n    {pose}\n")
    assert (draft, entry(report, "amcl.initial_pose.x").outcome) == ({}, ImportOutcome.NO_EFFECT)
    draft, report = imported("amcl:\n  ros__parameters: {set_initial_pose: true, initial_pose.x: here}\n")
    assert (draft, entry(report, "amcl.initial_pose.x").outcome) == ({}, ImportOutcome.REFUSED)


def test_speed_filters_take_their_conversion_and_zones_around_the_robot_stay_on_it() -> None:
    draft, report = imported(
        """
speed_costmap_filter_info_server:
  ros__parameters: {type: 1, base: 100.0, multiplier: -1.0, mask_topic: /m}
keepout_costmap_filter_info_server:
  ros__parameters: {type: 0, base: 0.0, multiplier: 1.0}
collision_monitor:
  ros__parameters:
    polygons: [Stop]
    Stop: {type: circle, radius: 0.4, action_type: stop}
"""
    )
    assert draft["parameters"] == {"speed_filter": {"type": 1, "base": 100.0, "multiplier": -1.0}}
    assert "no speeds" in entry(report, "keepout_costmap_filter_info_server.base").text
    assert "keep the collision monitor on the robot" in entry(report, "collision_monitor.Stop.radius").text


def test_names_without_values_have_no_effect() -> None:
    draft, report = imported("amcl:\n  ros__parameters: {}\nmap_server:\n  ros__parameters:\n    yaml_filename:\n")
    assert draft == {}
    assert [(e.part, e.text) for e in report.entries] == [
        ("amcl", "has no value"), ("map_server.yaml_filename", "has no value"),
    ]  # fmt: skip


def test_files_of_ros_1_are_refused() -> None:
    with pytest.raises(InvalidParameter, match="ros__parameters"):
        imported("move_base: {controller_frequency: 10.0}")


def test_many_unknown_names_take_little_time() -> None:
    names = "".join(f"    name_{number}: 1.0\n" for number in range(3_000))
    _, report = imported("controller_server:\n  ros__parameters:\n" + names)
    assert report.counts()["refused"] == 3_000


ODD = [None, True, 0, -1, 10**30, -0.5, math.nan, "", "x", "$(var a)", [], ["a", 1], [[0.1, 0.2]], {"a": 1}]


@pytest.mark.parametrize("odd", ODD, ids=repr)
def test_files_with_odd_values_still_become_robot_files_that_are_accepted(odd: object) -> None:
    """The plug-ins and lists stay as they are, so that all their parameters are read."""

    def changed(table: dict[str, Any]) -> dict[str, Any]:
        return {
            name: changed(value) if isinstance(value, dict) and value
            else value if name == "plugin" or isinstance(value, list) else odd
            for name, value in table.items()
        }  # fmt: skip

    file = yaml.safe_load((ROOT / "docs" / "examples" / "nav2_turtlebot4.yaml").read_text())
    translation = import_nav2(yaml.safe_dump(changed(file)).encode(), "nav2.yaml")
    accepted = robot_file([translation], {"map": "office"}, refusal)
    assert refusal(accepted) is None
    assert parse_robot_file(json.dumps(accepted)).base_local_planner == "dwa"
