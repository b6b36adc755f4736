"""Parameter files of ROS 1's navigation: which program reads a parameter, and what becomes of it."""

import pytest

from ppaas.errors import InvalidParameter
from ppaas.imports.parameters.clone_check import refusal
from ppaas.imports.parameters.draft import Translation, robot_file
from ppaas.imports.parameters.ros1.importing import import_ros1, import_ros1_files
from tests.support.imported_parameters import entry_of, outcomes, refused

COMMON = """
robot_radius: 0.2
footprint: [[-0.2, -0.2], [-0.2, 0.2], [0.2, 0.2], [0.2, -0.2]]
obstacle_range: 2.5
inflation_radius: 0.6
observation_sources: laser
laser: {data_type: LaserScan, topic: /scan, marking: true, clearing: true}
inflation_layer: {cost_scaling_factor: 4.0}
"""

LOCAL = """
local_costmap: {width: 5, height: 4.0, publish_frequency: 20.0, transform_tolerance: 0.3, inflation_radius: 0.4}
global_costmap: {width: 100, track_unknown_space: false, static_layer: {lethal_cost_threshold: 70}}
"""

DWA = """
DWAPlannerROS: {max_vel_x: 0.5, max_vel_trans: 0.4, min_rot_vel: 0.3, vy_samples: 1, yaw_goal_tolerance: 0.2}
TebLocalPlannerROS: {max_vel_x: 0.9, footprint_model: {type: point}}
"""

TEB = "TebLocalPlannerROS: {max_vel_x: 0.4, max_vel_x_backwards: 0.2, theta_stopped_vel: 0.15, min_turning_radius: 0.5}"


def files(**texts: str) -> list[Translation]:
    return import_ros1_files([(text.encode(), f"{name}.yaml") for name, text in texts.items()], "hall")


def one(text: str) -> Translation:
    return import_ros1(text.encode(), "f.yaml", "hall")


def parameters(translations: list[Translation]) -> dict[str, dict[str, object]]:
    """Return the parameters of the robot file, which its clone accepts."""
    file = robot_file(translations, {"map": "office"}, refusal)
    assert refusal(file) is None
    found: dict[str, dict[str, object]] = file["parameters"]
    return found


def test_common_parameters_are_those_of_both_costmaps() -> None:
    found = parameters(files(common=COMMON))
    costs = {"inflation_radius": 0.6, "cost_scaling_factor": 4.0}
    corners = [[-0.2, -0.2], [-0.2, 0.2], [0.2, 0.2], [0.2, -0.2]]
    assert found == {
        "global_costmap": {"footprint": corners, **costs},
        "local_costmap": {"obstacle_range": 2.5, **costs},
    }


@pytest.mark.parametrize("empty", ["[]", "'[]'", "''"])
def test_beside_an_empty_footprint_the_radius_counts(empty: str) -> None:
    found = one(f"{{robot_radius: 0.3, footprint: {empty}}}")
    assert found[0]["parameters"] == {"global_costmap": {"robot_radius": 0.3}}
    assert entry_of(found, "footprint").text.endswith("sets nothing")


def test_a_footprint_wins_over_a_radius_as_in_costmap_2d() -> None:
    radius, outline = files(a="robot_radius: 0.3", b="global_costmap: {footprint: '[[0.1,0],[0,0.1],[-0.1,-0.1]]'}")
    assert radius[0]["parameters"]["global_costmap"] == {}
    assert entry_of(radius, "robot_radius").text == "footprint is given, too, and wins"
    assert outline[0]["parameters"]["global_costmap"]["footprint"][0] == [0.1, 0.0]


def test_each_costmap_has_its_own_parameters() -> None:
    found = parameters(files(local=LOCAL))
    assert found["local_costmap"] == {"width": 5, "height": 4.0, "publish_frequency": 10.0, "inflation_radius": 0.4}
    assert found["global_costmap"] == {"lethal_cost_threshold": 70}
    assert found["static_layer"] == {"track_unknown_space": False}


def test_ranges_are_those_of_the_laser_and_layers_that_are_off_set_nothing() -> None:
    into = one(
        "local_costmap:\n"
        "  obstacles:\n    scan: {data_type: LaserScan, obstacle_range: 2.8}\n"
        "    camera: {data_type: PointCloud2, obstacle_range: 90}\n"
        "  inflation: {enabled: false, inflation_radius: 0.5}\n"
    )
    assert parameters([into]) == {"local_costmap": {"obstacle_range": 2.8}}
    assert entry_of(into, "local_costmap.obstacles.camera.obstacle_range").outcome.value == "no effect"
    assert "its layer is off" in entry_of(into, "local_costmap.inflation.inflation_radius").text


def test_the_local_planner_of_move_base_drives_whatever_file_names_it() -> None:
    planner, named = files(
        planner=DWA, base="base_local_planner: dwa_local_planner/DWAPlannerROS\nplanner_frequency: 2"
    )
    assert named[0]["base_local_planner"] == "dwa"
    assert planner[0]["parameters"] == {
        "dwa": {"max_vel_x": 0.4, "min_vel_theta": 0.3, "yaw_goal_tolerance": 0.2}
    }  # fmt: skip
    assert entry_of(planner, "TebLocalPlannerROS.max_vel_x").text == "the robot drives with DWAPlannerROS"
    assert entry_of(planner, "DWAPlannerROS.max_vel_x").text == "DWAPlannerROS.max_vel_trans is lower, and bounds it"


def test_a_planner_that_is_not_named_drives_if_it_has_parameters() -> None:
    into = one(TEB)
    assert into[0]["base_local_planner"] == "mppi"
    assert into[0]["parameters"]["mppi"] == {"max_vel_x": 0.4, "min_vel_x": -0.2, "rot_stopped_vel": 0.15}
    assert outcomes(into)["TebLocalPlannerROS.min_turning_radius"] == "no effect"
    both = one("DWAPlannerROS: {max_vel_x: 0.5}\nTrajectoryPlannerROS: {max_vel_x: 0.3, acc_lim_th: 2.0}")
    assert both[0]["parameters"]["dwa"] == {"max_vel_x": 0.3, "acc_lim_theta": 2.0}


def test_files_of_a_planner_may_be_without_its_name() -> None:
    assert one("teb_autosize: true\ndt_ref: 0.3\nmax_vel_x: 0.4\nmax_vel_x_backwards: 0.1")[0]["parameters"] == {
        "mppi": {"max_vel_x": 0.4, "min_vel_x": -0.1}
    }
    assert one("sim_time: 2.0\npath_distance_bias: 20.0\ngoal_distance_bias: 10.0\nmax_trans_vel: 0.5")[0][
        "parameters"
    ]["dwa"] == {"sim_time": 2.0, "path_distance_bias": 20.0, "goal_distance_bias": 10.0, "max_vel_x": 0.5}  # fmt: skip


def test_global_planner_searches_by_dijkstra_or_astar() -> None:
    base, own = files(
        base="base_global_planner: global_planner/GlobalPlanner",
        own="GlobalPlanner: {use_dijkstra: false, allow_unknown: false, cost_factor: 0.55}",
    )
    assert base[0] == {"base_global_planner": "astar"}
    assert own[0] == {"parameters": {"astar": {"allow_unknown": False}}}
    assert one("base_global_planner: navfn/NavfnROS")[0] == {"base_global_planner": "navfn"}
    assert one("NavfnROS: {default_tolerance: 0.3}")[0] == {"parameters": {"move_base": {"default_tolerance": 0.3}}}


def test_recovery_behaviours_have_their_parameters_by_name() -> None:
    text = (
        "move_base:\n  recovery_behaviors:\n"
        "  - {name: clear_far, type: clear_costmap_recovery/ClearCostmapRecovery}\n"
        "  - {name: turn, type: rotate_recovery/RotateRecovery}\n"
        "  clear_far: {reset_distance: 2.0, layer_names: [obstacle_layer, sonar]}\n"
        "  turn: {max_rotational_vel: 0.8, sim_granularity: 0.1, max_rot: 1}\n"
    )
    into = one(text)
    assert parameters([into]) == {
        "move_base": {
            "recovery_behaviors": [
                {"name": "clear_far", "type": "clear_costmap_recovery"}, {"name": "turn", "type": "rotate_recovery"},
            ]
        },
        "clear_far": {"reset_distance": 2.0, "layer_names": ["obstacles"]},
        "turn": {"max_rotational_vel": 0.8},
    }  # fmt: skip
    assert outcomes(into)["move_base/turn.max_rot"] == "refused"


def test_the_namespace_of_a_robot_may_precede_its_programs() -> None:
    into = one(
        "robot1:\n  move_base: {planner_frequency: 2.0, DWAPlannerROS: {max_vel_x: 0.4}}\n  amcl: {kld_z: 0.98}\n"
    )
    assert parameters([into]) == {
        "move_base": {"planner_frequency": 2.0},
        "dwa": {"max_vel_x": 0.4},
        "amcl": {"kld_z": 0.98},
    }
    assert refused(into) == []


def test_programs_beside_move_base_may_be_in_the_same_file() -> None:
    found = one("amcl: {odom_alpha1: 0.3, laser_max_range: 12.0}\nslam_gmapping: {delta: 0.1}\nmap_server: {port: 1}")
    assert found[0]["parameters"] == {
        "amcl": {"odom_alpha1": 0.3, "laser_max_range": 12.0}, "grid_slam": {"delta": 0.1},
    }  # fmt: skip
    assert found[0]["map"] == "new:hall"
    assert outcomes(found)["map_server"] == "refused"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("base_local_planner: dwa_planner/DWAPlanerROS", "there is no local planner 'dwa_planner/DWAPlanerROS'"),
        ("base_global_planner: my_planner/Fast", "there is no planner 'my_planner/Fast'"),
        ("recovery_behaviors: [{name: a, type: move_slow_and_clear/MoveSlowAndClear}]", "no recovery behaviour"),
        ("recovery_behaviors: often", "it must be a list"),
        ("footprint: [[0, 1]]", "at least three corners"),
        ("footprint: [[0, 1, 2], [1, 1, 1], [2, 2, 2]]", "a list of corners"),
        ("DWAPlannerROS: {max_vel_trans: fast}", "it must be a number"),
        ("controler_frequency: 5.0\nplanner_frequency: 1.0", "did you mean 'controller_frequency'?"),
        ("base_local_planner: $(arg planner)", "filled in by a launch file"),
    ],
)
def test_what_means_nothing_is_refused(text: str, words: str) -> None:
    into = one(text)
    assert any(words in each for each in refused(into)), refused(into)
    parameters([into])


def test_a_file_of_ros_2_is_an_error() -> None:
    with pytest.raises(InvalidParameter, match=r"f\.yaml has ros__parameters"):
        one("amcl: {ros__parameters: {z_hit: 0.5}}")


FLEX = """
planners: [{name: global, type: global_planner/GlobalPlanner}, {name: navfn, type: navfn/NavfnROS}]
controllers: [{name: window, type: dwa_local_planner/DWAPlannerROS}, {name: band, type: eband_local_planner/Band}]
planner_max_retries: 3
recovery_enabled: false
controller_max_retries: 10
window: {max_vel_x: 0.4}
"""


def test_the_first_plugins_of_move_base_flex_plan_and_drive() -> None:
    found = one(FLEX)
    file = robot_file([found], {"map": "office"}, refusal)
    assert (file["base_global_planner"], file["base_local_planner"]) == ("dijkstra", "dwa")
    assert file["parameters"] == {
        "move_base": {"max_planning_retries": 3, "recovery_behavior_enabled": False},
        "dwa": {"max_vel_x": 0.4},
    }
    assert refused(found) == []
    assert entry_of(found, "planners").text == "base_global_planner = 'dijkstra'"
    assert entry_of(found, "controllers band").text == "the first plug-in of the list counts"


def test_plugins_of_move_base_flex_may_be_in_another_file_than_their_parameters() -> None:
    found = files(
        plugins="controllers: [{name: window, type: dwa_local_planner/DWAPlannerROS}]", own="window: {max_vel_x: 0.3}"
    )
    assert parameters(found) == {"dwa": {"max_vel_x": 0.3}}


def test_a_list_of_plugins_that_is_none_is_refused() -> None:
    assert refused(one("controllers: dwa_local_planner/DWAPlannerROS")) == ["it must be a list of {name: …, type: …}"]


def test_a_recovery_behaviour_that_is_not_known_is_named_by_its_type() -> None:
    found = one("recovery_behaviors: [{name: creep, type: creep/Creep}]\ncreep: {speed: 0.1}")
    assert entry_of(found, "creep.speed").text == "the recovery behaviour creep/Creep is not known"


def test_a_name_that_another_program_reads_has_no_effect_where_it_stands() -> None:
    layer = "obstacles: {enabled: true, heading_scoring: true}"
    found = one(f"obstacle_range: 2.0\nmeter_scoring: true\nfootprint_model: point\n{layer}")
    assert refused(found) == []
    reason = "a parameter of TrajectoryPlannerROS, which does not read it here"
    assert entry_of(found, "meter_scoring").text == entry_of(found, "obstacles.heading_scoring").text == reason
    assert entry_of(found, "footprint_model").text.startswith("a parameter of TebLocalPlannerROS")


def test_a_layer_of_an_unknown_type_is_named_by_its_type() -> None:
    layers = "plugins:\n- {name: edge, type: 'my_layers::EdgeLayer'}\n"
    common, layer = files(common=layers, layer="edge: {strength: 3}")
    assert refused(common) == refused(layer) == []
    assert entry_of(layer, "edge").text == "of my_layers::EdgeLayer, which is not known"


def test_radii_of_early_costmaps_and_the_smoother_of_velocities_have_no_effect() -> None:
    found = one("inscribed_radius: 0.2\ncircumscribed_radius: 0.3\ninflation_radius: 0.5")
    assert entry_of(found, "inscribed_radius").text == "both follow from the footprint"
    smoother = one("speed_lim_v: 0.7\naccel_lim_v: 1.0\nfrequency: 20.0\nrobot_feedback: 2")
    assert set(outcomes(smoother).values()) == {"no effect"}
    assert smoother[0] == {}
