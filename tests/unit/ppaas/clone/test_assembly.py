"""Assembly of a clone: its nodes and parameters."""

import json

import pytest

from ppaas.clone.assembly import build_clone
from ppaas.clone.planning_container import build_planning
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import InvalidParameter, NotFound
from ppaas.messages.base.rosapi import GetParamRequest
from ppaas.nodes.graph import Graph
from ppaas.nodes.nav2_actions import NAV2_ACTIONS
from ppaas.robot_model.known_models import robot_model
from tests.support.world.planar_world import walled_map

LAYERS = build_layers(walled_map(4, 3, []))


def clone(**options) -> Graph:
    graph = Graph()
    build_clone(graph, LAYERS, **{"model": "turtlebot2", "initial_pose": (1.0, 1.0, 0.0)} | options)
    return graph


def test_a_clone_has_the_topics_and_services_of_ros():
    graph = clone()
    assert set(graph.nodes) == {
        "map_server", "robot_state_publisher", "amcl", "move_base", "waypoint_follower", "docking_server",
        "parameter_server",
        "tf2_web_republisher",
    }  # fmt: skip
    assert {
        "map", "map_updates", "scan", "odom", "tf", "tf_static", "robot_description", "initialpose", "amcl_pose",
        "amcl/status",
        "particlecloud", "cmd_vel",
        "plan", "local_plan", "global_costmap/costmap", "local_costmap/costmap", "move_base/global_costmap/costmap",
        "move_base/local_costmap/costmap", "local_costmap/published_footprint", "move_base/local_costmap/footprint",
        "move_base_simple/goal", "move_base/goal", "move_base/cancel", "move_base/status", "move_base/feedback",
        "move_base/result", "move_base/current_goal", "goal_update", "dynamic_pose", "move_base/goal_update",
        "robots", "people", "battery_state", "detected_dock_pose", "docking_server/status", "lift", "lift_state",
        "local_costmap/footprint",
        "people_coordinator/state", "speed_limit", "stop/state", "teleop_cmd", "teleop_state", "follow_waypoints/goal",
        "follow_waypoints/cancel",
        "follow_waypoints/status", "follow_waypoints/feedback", "follow_waypoints/result", "tf2_web_republisher/goal",
        "tf2_web_republisher/cancel", "tf2_web_republisher/status", "tf2_web_republisher/feedback",
        "tf2_web_republisher/result",
        "goal_pose", "navigate_to_pose/feedback", *(topic.name for action in NAV2_ACTIONS for topic in action),
    } == set(graph.topics)  # fmt: skip
    assert set(graph.services) == {
        "static_map", "keepout_filter_mask", "speed_filter_mask", "map_zones", "move_base/make_plan",
        "move_base/compute_path", "is_path_valid",
        "move_base/clear_costmaps", "global_costmap/clear_entirely_global_costmap",
        "local_costmap/clear_entirely_local_costmap", "rosapi/get_param", "rosapi/set_param",
        "rosapi/has_param", "rosapi/delete_param", "rosapi/search_param", "rosapi/get_param_names",
        "republish_tfs", "global_localization", "request_nomotion_update",
    }  # fmt: skip


def test_planning_container_has_map_and_planner_only():
    graph = Graph()
    build_planning(graph, LAYERS)
    assert set(graph.nodes) == {"map_server", "planner_server"}
    masks = {"keepout_filter_mask", "speed_filter_mask", "map_zones"}
    planning = {"make_plan", "compute_path", "compute_packed_path", "compute_costs", "compute_fleet_plan"}
    assert set(graph.services) == {"static_map"} | planning | masks


@pytest.mark.parametrize(
    "options",
    [
        {"base_local_planner": "dwa_local_planner/DWAPlannerROS", "parameters": {"DWAPlannerROS": {"sim_time": 1.0}}},
        {"parameters": {"dwa": {"sim_time": 1.0}}},
        {"parameters": {"dwa_local_planner/DWAPlannerROS": {"max_vel_x": 0.3}}},
        {"parameters": {"dijkstra": {"allow_unknown": False}}},
        {"base_global_planner": "global_planner/GlobalPlanner", "parameters": {"GlobalPlanner": {}}},
        {"base_global_planner": "navfn/NavfnROS", "parameters": {"NavfnROS": {"use_astar": True}}},
        {"base_global_planner": "navfn", "parameters": {"nav2_navfn_planner/NavfnPlanner": {"allow_unknown": False}}},
        {"parameters": {"NavfnROS": {"use_astar": True}}},
        {"parameters": {"move_base": {"controller_frequency": 5, "base_local_planner": "dwa"}}},
        {"parameters": {"amcl": {"min_particles": 100}, "local_costmap": {"width": 4.0}}},
        {"parameters": {"conservative_reset": {"reset_distance": 1.5}, "rotate_recovery": {"acc_lim_th": 2.0}}},
        {
            "parameters": {
                "move_base": {"recovery_behaviors": [{"name": "back", "type": "nav2_behaviors/BackUp"}]},
                "back": {"backup_dist": 0.2},
            }
        },
        {"parameters": {"waypoint_follower": {"stop_on_failure": False, "loop_rate": 20}}},
        {"parameters": {"robot_state_publisher": {"laser_frame": "hokuyo"}}},
    ],
)
def test_parameters_are_accepted_under_ros_names(options):
    assert "move_base" in clone(**options).nodes


def test_get_param_returns_parameters_in_use_with_defaults():
    graph = clone(
        base_local_planner="dwa_local_planner/DWAPlannerROS",
        parameters={"DWAPlannerROS": {"sim_time": 1.25}, "move_base": {"controller_frequency": 5}},
    )
    answers = []
    graph.call("rosapi/get_param", GetParamRequest("/"), answers.append)
    values = json.loads(answers[0].value)
    assert values["dwa"]["sim_time"] == 1.25
    assert values["dwa"]["max_vel_x"] == robot_model("turtlebot2").limits.max_vel_x
    assert values["move_base"]["controller_frequency"] == 5.0
    assert values["move_base"]["base_local_planner"] == "dwa_local_planner/DWAPlannerROS"
    assert values["dijkstra"]["allow_unknown"] is True
    assert {"amcl", "local_costmap", "robot_state_publisher", "rotate_recovery"} < set(values)


def test_planner_parameters_apply_under_all_its_names():
    graph = clone(
        base_global_planner="navfn/NavfnROS",
        parameters={"navfn": {"use_astar": True}, "astar": {"allow_unknown": False}},
    )
    answers = []
    graph.call("rosapi/get_param", GetParamRequest("/"), answers.append)
    values = json.loads(answers[0].value)
    assert values["navfn"] == {"allow_unknown": True, "use_astar": True}
    assert values["astar"]["allow_unknown"] is False
    paths = graph.nodes["move_base"]._paths.services
    for name in ("navfn", "navfn/NavfnROS", "nav2_navfn_planner/NavfnPlanner"):
        assert paths._planner(name) is paths._planner("navfn")
    assert paths._planner("navfn").use_astar
    assert paths._planner("nav2_smac_planner/SmacPlanner2D").allow_unknown is False
    assert paths._planner("dijkstra").allow_unknown is True


@pytest.mark.parametrize(
    ("parameters", "text"),
    [
        (
            {"movebase": {}},
            "unknown node 'movebase'; known: aggressive_reset, amcl, conservative_reset, dijkstra, docking_server",
        ),
        ({"move_base": {"controller_freq": 5.0}}, "controller_freq.*known: .*controller_frequency"),
        ({"move_base": {"controller_frequency": "fast"}}, "controller_frequency"),
        ({"move_base": {"controller_frequency": -1.0}}, "controller_frequency must be above 0"),
        ({"amcl": {"max_particles": 10**9}}, "max_particles"),
        ({"amcl": []}, "'amcl' must be an object"),
        ({"local_costmap": {"width": -1.0}}, "width"),
        ({"dwa": {"warp": 9}}, "warp"),
        ({"conservative_reset": {"reset_distance": -1.0}}, "reset_distance"),
        ({"rotate_recovery": {"reset_distance": 1.0}}, "reset_distance.*known: .*max_rotational_vel"),
        ({"move_base": {"recovery_behaviors": [{"name": "rest"}]}}, "`type`.*recovery_behaviors"),
        ({"move_base": {"recovery_behaviors": {"rest": "wait"}}}, "recovery_behaviors"),
        ({"waypoint_follower": {"loop_rate": 0}}, "loop_rate"),
        ({"waypoint_follower": {"waypoint_pause_duration": -1}}, "waypoint_pause_duration"),
        ({"dijkstra": {"heuristic": 1}}, "'dijkstra' has no parameter 'heuristic'; known: allow_unknown"),
        ({"dijkstra": {"allow_unknown": "no"}}, "'allow_unknown' of planner 'dijkstra': Expected `bool`, got `str`"),
        ({"navfn": {"use_astar": 1}}, "'use_astar' of planner 'navfn': Expected `bool`, got `int`"),
    ],
)
def test_invalid_parameter_is_refused_by_name(parameters, text):
    with pytest.raises(InvalidParameter, match=text):
        clone(parameters=parameters)


@pytest.mark.parametrize(
    ("option", "known"),
    [("model", "turtlebot2"), ("base_global_planner", "dijkstra"), ("base_local_planner", "dwa")],
)
def test_unknown_plug_in_error_lists_the_known_ones(option, known):
    with pytest.raises(NotFound, match=f"'nonsense'.*{known}"):
        clone(**{option: "nonsense"})


def test_unknown_recovery_behaviour_error_lists_the_known_ones():
    behaviors = [{"name": "jump", "type": "jump_recovery/JumpRecovery"}]
    with pytest.raises(NotFound, match=r"'jump_recovery/JumpRecovery'; known: back_up, clear_costmap_recovery, rot"):
        clone(parameters={"move_base": {"recovery_behaviors": behaviors}})
