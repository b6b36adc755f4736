"""Files of Dashing, Eloquent, Foxy and Galactic: other nodes, lists of plug-ins, names of the Smac planner."""

from typing import Any

from ppaas.imports.parameters.clone_check import refusal
from ppaas.imports.parameters.nav2.importer import import_nav2
from ppaas.imports.report import ImportOutcome, ImportReport, ReportEntry

DASHING = """
dwb_controller:
  ros__parameters:
    use_sim_time: true
    max_vel_x: 0.31
    min_speed_xy: 0.04
    xy_goal_tolerance: 0.2
    min_y_velocity_threshold: 0.5
    PathDist.scale: 30.0
    max_vel_z: 1.0
navfn_planner:
  ros__parameters: {tolerance: 0.3, use_astar: true}
world_model:
  ros__parameters: {use_sim_time: true}
bt_navigator:
  ros__parameters: {bt_xml_filename: tree.xml}
local_costmap:
  local_costmap:
    ros__parameters:
      plugin_names: [seen, puffed]
      plugin_types: ["nav2_costmap_2d::ObstacleLayer", "nav2_costmap_2d::InflationLayer"]
      puffed.inflation_radius: 0.4
      seen: {enabled: true}
      observation_sources: front
      front: {topic: /scan, marking: true, clearing: true, max_obstacle_height: 1.5}
"""


def imported(text: str) -> tuple[dict[str, Any], ImportReport]:
    draft, report = import_nav2(text.encode(), "nav2.yaml")
    assert refusal({"map": "office", **draft}) is None
    return draft, report


def entry(report: ImportReport, part: str) -> ReportEntry:
    (found,) = [each for each in report.entries if each.part == part]
    return found


def test_nodes_of_one_plugin_are_sections_of_the_servers() -> None:
    draft, report = imported(DASHING)
    assert (draft["base_local_planner"], draft["base_global_planner"]) == ("dwa", "navfn")
    assert draft["parameters"]["dwa"] == {
        "max_vel_x": 0.31, "min_vel_trans": 0.04, "path_distance_bias": 30.0, "xy_goal_tolerance": 0.2,
    }  # fmt: skip
    assert draft["parameters"]["navfn"] == {"use_astar": True}
    assert draft["parameters"]["move_base"]["default_tolerance"] == 0.3
    assert entry(report, "dwb_controller").text == "base_local_planner = 'dwa': dwb_core::DWBLocalPlanner"
    assert entry(report, "dwb_controller.max_vel_x").to == "parameters.dwa.max_vel_x"
    assert entry(report, "dwb_controller.min_y_velocity_threshold").text == "odometry is used as it is"
    assert entry(report, "world_model").text == "the clone has its costmaps itself"
    assert [each.part for each in report.of(ImportOutcome.REFUSED)] == ["dwb_controller.max_vel_z"]


def test_a_second_name_of_the_node_of_the_controller_is_known() -> None:
    draft, _ = imported("DwbController:\n  ros__parameters: {max_vel_x: 0.22}\n")
    assert draft == {"base_local_planner": "dwa", "parameters": {"dwa": {"max_vel_x": 0.22}}}


def test_plugins_are_listed_beside_their_names() -> None:
    draft, report = imported(DASHING)
    assert draft["parameters"]["local_costmap"] == {"inflation_radius": 0.4}
    costmap = "local_costmap/local_costmap"
    assert entry(report, f"{costmap}.plugin_names").text == "names the sections seen, puffed"
    assert entry(report, f"{costmap}.plugin_types").outcome == ImportOutcome.NO_EFFECT
    assert entry(report, f"{costmap}.front.topic").text == "a robot publishes all its scans on the topic scan"


def test_planners_and_controllers_of_eloquent_are_listed_beside_their_names() -> None:
    draft, report = imported(
        """
        controller_server:
          ros__parameters:
            controller_plugin_ids: [Drive]
            controller_plugin_types: ["dwb_core::DWBLocalPlanner"]
            Drive.max_vel_x: 0.4
        planner_server:
          ros__parameters:
            planner_plugin_ids: [Plan]
            planner_plugin_types: ["nav2_navfn_planner/NavfnPlanner"]
            Plan.allow_unknown: false
        """
    )
    assert draft["parameters"] == {"dwa": {"max_vel_x": 0.4}, "navfn": {"allow_unknown": False}}
    assert not list(report.of(ImportOutcome.REFUSED))


def test_the_smac_planner_of_galactic_has_names_that_its_search_does_not_use() -> None:
    draft, report = imported(
        """
        planner_server:
          ros__parameters:
            planner_plugins: [Plan]
            Plan:
              plugin: "nav2_smac_planner/SmacPlanner2D"
              tolerance: 0.2
              angle_quantization_bins: 72
              non_straight_penalty: 1.05
              smoother:
                smoother: {w_curve: 20.0}
                optimizer: {max_time: 0.2, advanced: {max_line_search_step_expansion: 40}}
        """
    )
    assert draft == {"base_global_planner": "astar", "parameters": {"move_base": {"default_tolerance": 0.2}}}
    assert not list(report.of(ImportOutcome.REFUSED))


def test_a_name_that_another_plugin_or_node_reads_has_no_effect() -> None:
    draft, report = imported(
        """
        local_costmap:
          local_costmap:
            ros__parameters: {inflation_radius: 0.3}
        planner_server:
          ros__parameters: {controller_frequency: 9.0, use_astar: true}
        """
    )
    assert "parameters" not in draft
    assert {each.part: each.text.partition(",")[0] for each in report.entries} == {
        "local_costmap/local_costmap.inflation_radius": "a parameter of nav2_costmap_2d::InflationLayer",
        "planner_server.controller_frequency": "a parameter of controller_server",
        "planner_server.use_astar": "a parameter of nav2_navfn_planner::NavfnPlanner",
    }


def test_a_limit_below_zero_is_none_as_in_dwb() -> None:
    draft, report = imported(
        "controller_server:\n  ros__parameters:\n    controller_plugins: [Drive]\n"
        "    Drive: {plugin: 'dwb_core::DWBLocalPlanner', min_speed_xy: -1.0, min_speed_theta: -2.0}\n"
    )
    assert draft == {"base_local_planner": "dwa"}
    assert entry(report, "controller_server.Drive.min_speed_xy").outcome == ImportOutcome.NO_EFFECT
