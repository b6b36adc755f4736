"""Set-up of Nav2 and slam_toolbox: what a clone has in use is in its files, or in the report."""

import json
import sys
import types
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
import yaml

from ppaas.errors import InvalidParameter
from ppaas.exports.ros2.releases import Release
from ppaas.exports.ros2.robot import MapToExport, robot_to_export
from ppaas.exports.ros2.setup import Ros2Setup, export_ros2
from ppaas.geometry import Pose2D
from ppaas.imports.report import ImportOutcome
from ppaas.maps.formats.map_files import load_map
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.zones.reading import zones_of

INFO = GridInfo(0.1, 60, 40, Pose2D(-1.0, -1.0))
CAMERA = {"depthimage_to_laserscan": {"range_max": 4.0}, "octomap_server": {"resolution": 0.1}}
URDF = b"""<robot name="r">
<link name="base_link"><collision><geometry><box size="0.6 0.4 0.3"/></geometry></collision></link><link name="laser"/>
<joint name="l" type="fixed"><parent link="base_link"/><child link="laser"/><origin xyz="0.1 0 0.2"/></joint>
</robot>"""


def zone(kind: str, x: float, **rule: Any) -> dict[str, Any]:
    corners = [[x, 0.0], [x + 0.5, 0.0], [x + 0.5, 0.5], [x, 0.5], [x, 0.0]]
    geometry = {"type": "Polygon", "coordinates": [corners]}
    return {"type": "Feature", "properties": {"name": f"{kind} {x:g}", "kind": kind, **rule}, "geometry": geometry}


def dock(name: str, x: float, **rule: Any) -> dict[str, Any]:
    properties = {"name": name, "kind": "dock", "yaw": 0.5, **rule}
    return {"type": "Feature", "properties": properties, "geometry": {"type": "Point", "coordinates": [x, 1.0]}}


def map_of(*zones: dict[str, Any], masks: dict[str, GridMap] | None = None, has_octomap: bool = False) -> MapToExport:
    features = {"type": "FeatureCollection", "features": list(zones)}
    grid = GridMap(np.zeros(INFO.shape, np.int8), INFO)
    return MapToExport("office", grid, zones_of(json.dumps(features)), masks or {}, has_octomap)


def exported(
    file: dict[str, Any] | None = None,
    map_: MapToExport | None = None,
    release: Release = Release.JAZZY,
    urdf: bytes | None = None,
) -> Ros2Setup:
    wanted = {"map": "office"} | (file or {})
    on = None if wanted["map"].startswith("new:") else map_ or map_of()
    return export_ros2(robot_to_export("tb1", wanted, on, urdf), release)


def parameters(setup: Ros2Setup, node: str, file: str = "nav2_params.yaml") -> dict[str, Any]:
    document = yaml.safe_load(setup.files[file])
    table = document[node]
    found: dict[str, Any] = (table[node] if node.endswith("costmap") else table)["ros__parameters"]
    return found


def entries(setup: Ros2Setup, part: str) -> dict[str, str]:
    return {entry.outcome.value: entry.text for entry in setup.report.entries if entry.part == part}


@pytest.mark.parametrize("release", Release)
@pytest.mark.parametrize("controller", ["dwa", "mppi", "pure_pursuit"])
@pytest.mark.parametrize("planner", ["dijkstra", "lattice"])
def test_every_parameter_in_use_is_in_the_report(release: Release, controller: str, planner: str) -> None:
    file = {"base_local_planner": controller, "base_global_planner": planner, "parameters": CAMERA}
    robot = robot_to_export("tb1", {"map": "office"} | file, map_of())
    setup = export_ros2(robot, release)
    parts = {entry.part for entry in setup.report.entries}
    only_if_given = {
        "social_layer", "voxel_layer", "teleop", "robot_state_publisher", "keepout_filter", "speed_filter",
        "docking_server",
    }  # fmt: skip
    missing = {
        f"{section}.{name}"
        for section, table in robot.in_use.items()
        if section not in only_if_given
        for name, value in table.items()
        if value is not None and name not in ("footprint", "base_global_planner", "base_local_planner")
    } - parts
    assert missing == set()


def test_limits_tolerances_and_outline_are_the_robots_own() -> None:
    file = {"model": "turtlebot3_waffle", "parameters": {"dwa": {"xy_goal_tolerance": 0.3, "acc_lim_x": 1.5}}}
    setup = exported(file)
    server = parameters(setup, "controller_server")
    follow, checker = server["FollowPath"], server["general_goal_checker"]
    assert (follow["max_vel_x"], follow["max_speed_xy"], follow["max_vel_theta"]) == (0.26, 0.26, 1.82)
    assert (follow["acc_lim_x"], follow["decel_lim_x"]) == (1.5, -1.5)
    assert (checker["xy_goal_tolerance"], follow["xy_goal_tolerance"]) == (0.3, 0.3)
    for costmap in ("local_costmap", "global_costmap"):
        assert parameters(setup, costmap)["robot_radius"] == 0.22
    assert entries(setup, "dwa.max_vel_x") == {"taken": "controller_server.FollowPath.max_vel_x"}
    assert "no effect" in entries(setup, "dwa.cost_slowdown")


def test_a_footprint_is_text_in_both_costmaps() -> None:
    setup = exported(urdf=URDF)
    texts = {parameters(setup, costmap)["footprint"] for costmap in ("local_costmap", "global_costmap")}
    assert len(texts) == 1
    assert sorted(json.loads(texts.pop())) == [[-0.3, -0.2], [-0.3, 0.2], [0.3, -0.2], [0.3, 0.2]]
    assert setup.files["robot.urdf"] == URDF


def test_names_differ_between_releases() -> None:
    lattice = {"base_global_planner": "lattice", "base_local_planner": "pure_pursuit"}
    old, new = exported(lattice, release=Release.HUMBLE), exported(lattice, release=Release.ROLLING)
    plugins = [parameters(setup, "planner_server")["GridBased"]["plugin"] for setup in (old, new)]
    assert plugins == ["nav2_smac_planner/SmacPlannerHybrid", "nav2_smac_planner::SmacPlannerHybrid"]
    servers = [parameters(setup, "controller_server") for setup in (old, new)]
    assert servers[0]["FollowPath"]["desired_linear_vel"] == servers[1]["FollowPath"]["max_linear_vel"] == 0.65
    assert ("progress_checker_plugin" in servers[0], servers[1]["progress_checker_plugins"]) == (
        True,
        ["progress_checker"],
    )
    assert ["enable_stamped_cmd_vel" in server for server in servers] == [False, True]
    absent = entries(old, "pure_pursuit.use_fixed_curvature_lookahead")["no effect"]
    assert "has no FollowPath.use_fixed_curvature_lookahead" in absent


def test_defaults_that_are_tuned_for_our_algorithms_stay_nav2s_unless_the_robot_sets_them() -> None:
    by_default = exported({"base_local_planner": "mppi"})
    assert "batch_size" not in parameters(by_default, "controller_server")["FollowPath"]
    assert "tuned for our sampling" in entries(by_default, "mppi.batch_size")["no effect"]
    given = exported({"base_local_planner": "mppi", "parameters": {"mppi": {"batch_size": 1000}}})
    assert parameters(given, "controller_server")["FollowPath"]["batch_size"] == 1000
    slow = exported({"base_local_planner": "mppi", "parameters": {"move_base": {"controller_frequency": 10.0}}})
    assert parameters(slow, "controller_server")["FollowPath"]["model_dt"] == 0.1


def test_what_nav2_does_not_have_is_refused_by_name() -> None:
    setup = exported({"base_global_planner": "jps", "parameters": {"amcl": {"laser_z_hit": 0.5, "odom_drift": 0.1}}})
    assert parameters(setup, "planner_server")["GridBased"] == {
        "plugin": "nav2_navfn_planner::NavfnPlanner", "allow_unknown": True, "use_astar": True, "tolerance": 0.0,
    }  # fmt: skip
    assert parameters(setup, "amcl")["z_hit"] == 0.5
    assert "no noise of standing odometry" in entries(setup, "amcl.odom_drift")["no effect"]


def test_the_start_pose_and_the_frames_are_amcls() -> None:
    setup = exported({"initial_pose": [1.0, 2, 0.5]})
    amcl = parameters(setup, "amcl")
    assert amcl["initial_pose"] == {"x": 1.0, "y": 2.0, "z": 0.0, "yaw": 0.5}
    assert (amcl["odom_frame_id"], amcl["robot_model_type"]) == ("odom", "nav2_amcl::DifferentialMotionModel")
    assert json.loads(setup.files["robot.json"]) == {"map": "office", "initial_pose": [1.0, 2, 0.5]}


def test_a_robot_that_makes_a_map_has_slam_toolbox_and_no_map() -> None:
    own = {"grid_slam": {"delta": 0.1, "loop_search_maximum_distance": 8.0, "maxUrange": 12.0}}
    setup = exported({"map": "new:office-2", "parameters": own})
    slam = parameters(setup, "slam_toolbox", "slam_toolbox_params.yaml")
    assert (slam["resolution"], slam["loop_search_maximum_distance"], slam["max_laser_range"]) == (0.1, 8.0, 12.0)
    assert "scan_buffer_size" not in slam, "it is tuned for our matcher"
    assert "map.yaml" not in setup.files
    assert 'DeclareLaunchArgument("slam", default_value="true"' in setup.files["bringup.launch.py"].decode()
    assert entries(setup, "grid_slam.delta")["translated"] == "grid_slam.resolution = 0.1"


# -- masks -------------------------------------------------------------------------------------------------------------


def mask(setup: Ros2Setup, name: str) -> GridMap:
    return load_map(setup.files[f"{name}.yaml"], setup.files[f"{name}.pgm"])


def test_zones_are_masks_and_those_without_a_counterpart_are_named() -> None:
    times = [{"days": ["mon"], "from": "08:00", "to": "09:00"}]
    zones = (
        zone("keep_out", 0.0), zone("keep_out", 1.0, times=times), zone("speed_limit", 2.0, percent=50),
        zone("speed_limit", 2.3, max_speed=0.13), zone("speed_limit", 4.0, max_speed=2.0), zone("no_stop", 3.0),
    )  # fmt: skip
    setup = exported(map_=map_of(*zones))
    keepout, speed = mask(setup, "keepout_mask"), mask(setup, "speed_mask")
    at = INFO.to_cells([(0.25, 0.25), (1.25, 0.25), (2.05, 0.25), (2.45, 0.25), (4.25, 0.25), (3.25, 0.25)])
    assert [int(keepout.data[row, column]) for row, column in at] == [100, 100, 0, 0, 0, 0]
    assert [int(speed.data[row, column]) for row, column in at] == [0, 0, 50, 20, 0, 0], "0.13 of 0.65 m/s are 20 %"
    assert "in force always" in entries(setup, "zone keep_out 1")["translated"]
    assert entries(setup, "zone no_stop 3") == {"no effect": "Nav2 has no such rule of traffic: no_stop"}
    assert parameters(setup, "global_costmap")["filters"] == ["keepout_filter", "speed_filter"]
    assert parameters(setup, "local_costmap")["filters"] == ["keepout_filter"]
    info = parameters(setup, "speed_costmap_filter_info_server")
    assert (info["type"], info["base"], info["multiplier"]) == (1, 0.0, 1.0)


def test_masks_of_filters_are_added_in_the_cells_of_the_map() -> None:
    coarse = GridInfo(0.5, 4, 4, Pose2D(0.0, 0.0))
    values = np.zeros(coarse.shape, np.int8)
    values[0, 0], values[0, 1] = 100, 40
    masks = {name: GridMap(values, coarse) for name in ("keepout_filter", "speed_filter")}
    own = {
        "keepout_filter": {"filter_mask": "k"},
        "speed_filter": {"filter_mask": "s", "base": 100.0, "multiplier": -1.0},
    }
    setup = exported({"parameters": own}, map_of(zone("keep_out", 2.0), masks=masks))
    keepout, speed = mask(setup, "keepout_mask"), mask(setup, "speed_mask")
    row, column = INFO.to_cells([(0.25, 0.25)])[0]
    beside = INFO.to_cells([(0.75, 0.25)])[0]
    assert (keepout.data[row, column], keepout.data[tuple(beside)]) == (100, 40)
    assert (speed.data[row, column], speed.data[tuple(beside)]) == (1, 60), "0 % would be no limit"
    assert not keepout.data[tuple(INFO.to_cells([(-0.5, -0.5)])[0])]


def test_a_map_without_zones_has_no_filters() -> None:
    setup = exported(map_=map_of(has_octomap=True))
    assert not {"keepout_mask.yaml", "speed_mask.yaml"} & setup.files.keys()
    assert "filters" not in parameters(setup, "global_costmap")
    assert "Nav2 reads no octomap" in entries(setup, "map office: octomap")["no effect"]


# -- behaviour tree, launch file ---------------------------------------------------------------------------------------


def tree(setup: Ros2Setup) -> ElementTree.Element:
    return ElementTree.fromstring(setup.files["navigate_to_pose.xml"])


def test_recovery_behaviours_are_in_the_order_of_move_base() -> None:
    setup = exported()
    actions = next(tree(setup).iter("RoundRobin"))
    assert [child.tag for child in actions] == ["Sequence", "Spin", "Sequence", "Spin"]
    assert [each.tag for each in actions[0]] == ["ClearCostmapExceptRegion"] * 2
    assert actions[0][0].attrib["reset_distance"] == "3"
    assert [each.tag for each in actions[2]] == ["ClearEntireCostmap"] * 2
    assert next(tree(setup).iter("RecoveryNode")).attrib["number_of_retries"] == "4"
    assert next(tree(setup).iter("RateController")).attrib["hz"] == "1"
    assert tree(setup).attrib == {"BTCPP_format": "4"}


def test_own_recoveries_and_planning_on_demand() -> None:
    own = {
        "recovery_behaviors": [{"name": "w", "type": "wait"}, {"name": "b", "type": "back_up"}],
        "planner_frequency": 0.0,
    }
    setup = exported({"parameters": {"move_base": own, "w": {"wait_duration": 2.5}}}, release=Release.HUMBLE)
    actions = next(tree(setup).iter("RoundRobin"))
    assert [(each.tag, dict(each.attrib)) for each in actions] == [
        ("Wait", {"wait_duration": "3"}),
        ("BackUp", {"backup_dist": "0.3", "backup_speed": "0.15", "time_allowance": "10"}),
    ]
    assert (list(tree(setup).iter("RateController")), tree(setup).attrib) == ([], {})
    alone = exported({"parameters": {"move_base": {"recovery_behavior_enabled": False}}})
    assert list(tree(alone).iter("RecoveryNode")) == []


class Started(dict[str, Any]):
    """What a launch file starts: the arguments of an action."""


def launched(setup: Ros2Setup, folder: Path, monkeypatch: pytest.MonkeyPatch) -> list[Started]:
    """Run a launch file with stand-ins for ROS's packages, which no registry has; return its actions."""
    for name, content in setup.files.items():
        (folder / name).write_bytes(content)
    names = {
        "ament_index_python.packages": ("get_package_share_directory",),
        "launch": ("LaunchDescription",),
        "launch.actions": ("DeclareLaunchArgument", "IncludeLaunchDescription"),
        "launch.conditions": ("IfCondition", "UnlessCondition"),
        "launch.launch_description_sources": ("PythonLaunchDescriptionSource",),
        "launch.substitutions": ("LaunchConfiguration",),
        "launch_ros.actions": ("Node",),
        "launch_ros.parameter_descriptions": ("ParameterValue",),
    }
    for module, members in names.items():
        stand_in = types.ModuleType(module)
        for member in members:
            setattr(stand_in, member, lambda *given, _kind=member, **options: Started(options, kind=_kind, given=given))
        monkeypatch.setitem(sys.modules, module, stand_in)
    monkeypatch.setattr(
        sys.modules["ament_index_python.packages"], "get_package_share_directory", lambda name: f"/{name}"
    )
    monkeypatch.setattr(sys.modules["launch"], "LaunchDescription", list)
    path = folder / "bringup.launch.py"
    space: dict[str, Any] = {"__file__": str(path), "__name__": "bringup"}
    exec(compile(path.read_text(), path, "exec"), space)
    actions: list[Started] = space["generate_launch_description"]()
    return actions


@pytest.mark.parametrize("release", Release)
def test_the_launch_file_starts_every_node_that_has_parameters(
    release: Release, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    zones = map_of(zone("keep_out", 0.0), zone("speed_limit", 2.0, percent=50))
    setup = exported({"parameters": CAMERA}, zones, release)
    actions = launched(setup, tmp_path, monkeypatch)
    nodes = {action["name"]: action for action in actions if action["kind"] == "Node"}
    document = yaml.safe_load(setup.files["nav2_params.yaml"])
    assert set(document) - set(nodes) == {"local_costmap", "global_costmap"}, "they run in other nodes"
    (managed,) = (
        each["node_names"] for each in nodes["lifecycle_manager_navigation"]["parameters"] if "node_names" in each
    )
    servers = {name for name in nodes if name.endswith(("_server", "bt_navigator", "waypoint_follower"))}
    assert set(managed) == servers - {"map_server", "octomap_server"}
    given = [each for node in nodes.values() for each in node.get("parameters", ())]
    files = [str(value) for each in given for value in (each.values() if isinstance(each, dict) else [each])]
    named = {Path(file).name for file in files if file.startswith(str(tmp_path))}
    assert named == {"nav2_params.yaml", "map.yaml", "keepout_mask.yaml", "speed_mask.yaml", "navigate_to_pose.xml"}
    assert all((tmp_path / name).is_file() for name in named)


def test_a_robot_without_a_urdf_publishes_where_its_laser_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    actions = launched(exported({"model": "turtlebot3_burger"}), tmp_path, monkeypatch)
    (laser,) = (action for action in actions if action.get("name") == "laser_frame")
    assert laser["arguments"] == [
        "--x", "-0.032", "--y", "0", "--yaw", "0", "--frame-id", "base_link", "--child-frame-id", "base_scan",
    ]  # fmt: skip


def test_the_page_has_the_commands_and_what_is_missing() -> None:
    setup = exported({"parameters": {"traffic": {}, "teleop": {"max_rate": 10.0}}}, release=Release.KILTED)
    page = setup.files["README.md"].decode()
    assert "sudo apt install ros-kilted-navigation2 ros-kilted-slam-toolbox" in page
    assert "- `teleop.max_rate`: Nav2 has no driving by hand with leases" in page
    refused = list(setup.report.of(ImportOutcome.REFUSED))
    assert refused == []


def test_a_name_that_ends_a_docstring_is_no_code(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    robot = robot_to_export('x"""\nraise SystemExit\n"""', {"map": "office"}, map_of())
    assert launched(export_ros2(robot, Release.JAZZY), tmp_path, monkeypatch)


def test_a_frame_that_ends_a_string_is_no_code(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    frame = '"], x=["\\'
    own = {"robot_state_publisher": {"laser_frame": frame}}
    actions = launched(exported({"parameters": own}), tmp_path, monkeypatch)
    (laser,) = (action for action in actions if action.get("name") == "laser_frame")
    assert laser["arguments"][-1] == frame


def test_a_robot_that_localizes_itself_has_no_amcl(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    setup = exported({"initial_pose": [1, 2, 0], "parameters": {"amcl": {"localize": False, "laser_z_hit": 0.7}}})
    nodes = {action["name"]: action for action in launched(setup, tmp_path, monkeypatch) if action["kind"] == "Node"}
    assert "map_server" in nodes
    assert "amcl" not in nodes
    assert nodes["lifecycle_manager_localization"]["parameters"][0]["node_names"] == ["map_server"]
    assert "amcl" not in yaml.safe_load(setup.files["nav2_params.yaml"])
    assert entries(setup, "amcl.localize") == {"translated": "False: the launch file starts no amcl"}
    for part in ("initial_pose", "amcl.laser_z_hit"):
        assert entries(setup, part) == {"no effect": "the robot localizes itself"}
    assert "It localizes itself on `map.yaml`." in setup.files["README.md"].decode()


def test_a_file_that_the_clone_refuses_is_not_exported() -> None:
    with pytest.raises(InvalidParameter, match="min_particles"):
        exported({"parameters": {"amcl": {"min_particles": 0}}})
    with pytest.raises(InvalidParameter, match="needs its map 'office'"):
        robot_to_export("tb1", {"map": "office"})


TYPES = {
    "home": {"detection": "map", "staging_distance": 0.9, "charging_threshold": 0.2},
    "rear": {"detection": "v_shape", "dock_direction": "backward"},
    "shelf": {"detection": "legs", "distance": -0.4, "load": [[0.5, 0.3], [-0.5, 0.3], [-0.5, -0.3], [0.5, -0.3]]},
}


def with_docks(*names: str, release: Release = Release.JAZZY, **parameters: Any) -> Ros2Setup:
    marks = [dock(f"dock {name}", 1.0 + number, dock_type=name) for number, name in enumerate(names)]
    file = {"parameters": {"docking_server": {"dock_types": TYPES, **parameters}}}
    return exported(file, map_of(*marks), release)


def test_docks_of_the_map_are_those_of_the_docking_server() -> None:
    setup = with_docks("home", "rear", "shelf", max_retries=5, patience=9.0)
    server = parameters(setup, "docking_server")
    assert (server["max_retries"], server["controller"]["k_phi"]) == (5, 3.0)
    assert server["dock_plugins"] == ["home", "rear", "shelf_without_charge"]
    assert server["home"] == {
        "plugin": "opennav_docking::SimpleChargingDock", "staging_x_offset": -0.9, "docking_threshold": 0.015,
        "use_battery_status": True, "charging_threshold": 0.2, "use_external_detection_pose": False,
    }  # fmt: skip
    shelf = server["shelf_without_charge"]
    assert shelf["plugin"] == "opennav_docking::SimpleNonChargingDock" and shelf["use_external_detection_pose"]
    docks = yaml.safe_load(setup.files["docks.yaml"])["docks"]
    assert docks["dock home"] == {"type": "home", "frame": "map", "pose": [1.0, 1.0, 0.5]}
    assert docks["dock rear"]["pose"] == [2.0, 1.0, pytest.approx(0.5 - np.pi, abs=1e-4)]
    assert docks["dock shelf"]["type"] == "shelf_without_charge"
    assert server["dock_backwards"] and server["rear"]["staging_yaw_offset"] == pytest.approx(np.pi)
    assert "another one for those ahead" in entries(setup, "docking_server.dock_types")["refused"]
    assert "v_shape" in entries(setup, "docking_server.dock_types.rear")["refused"]
    assert "no effect" in entries(setup, "docking_server.patience")
    assert entries(setup, "zone dock home") == {"translated": "a dock in docks.yaml"}


def test_the_docking_server_is_started_with_its_docks() -> None:
    setup = with_docks("home")
    assert (
        b'"docking_server": ("opennav_docking", "opennav_docking", {"dock_database": "docks.yaml"})'
        in (setup.files["bringup.launch.py"])
    )
    assert "dock_backwards" not in parameters(setup, "docking_server")
    humble = with_docks("home", "shelf", release=Release.HUMBLE)
    plugins = parameters(humble, "docking_server")
    assert plugins["shelf_without_charge"]["plugin"] == "opennav_docking::SimpleChargingDock"
    assert plugins["shelf_without_charge"]["use_battery_status"] is False
    assert b"ros-humble-opennav-docking" in humble.files["README.md"]


def test_a_dock_that_the_robot_does_not_know_is_refused() -> None:
    setup = with_docks("home", "rocket")
    assert list(yaml.safe_load(setup.files["docks.yaml"])["docks"]) == ["dock home"]
    assert "no dock_type 'rocket'" in entries(setup, "dock 'dock rocket'")["refused"]


def test_a_map_without_docks_has_no_docking_server() -> None:
    setup = with_docks(max_retries=5)
    assert "docks.yaml" not in setup.files and b"docking_server" not in setup.files["nav2_params.yaml"]
    assert "the map has no docks" in entries(setup, "docking_server.max_retries")["no effect"]
