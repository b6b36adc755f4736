"""Export of a robot: the files of a set-up of Nav2 and slam_toolbox, and the report of what became of each part."""

import json
from dataclasses import dataclass
from typing import Any

from ppaas.exports.ros2.behavior_tree import IN_TREE, add_behaviors, behavior_tree
from ppaas.exports.ros2.costmaps import add_costmaps, add_mask_servers
from ppaas.exports.ros2.docking import DOCKS_FILE, add_docking
from ppaas.exports.ros2.draft import SetupDraft, renamed, same, without_effect
from ppaas.exports.ros2.driving import SERVER, add_controller, add_planner
from ppaas.exports.ros2.launch_file import LaunchFacts, launch_file, readme
from ppaas.exports.ros2.localization import SLAM, add_amcl, add_slam
from ppaas.exports.ros2.masks import masks_of
from ppaas.exports.ros2.releases import Release
from ppaas.exports.ros2.robot import RobotToExport
from ppaas.imports.parameters.rules import ParameterRule, ParameterRules
from ppaas.imports.report import ImportReport
from ppaas.maps.formats.map_files import save_map
from ppaas.nodes.map_server.costmap_filters import KEEPOUT_FILTER, SPEED_FILTER

NAV2_FILE, SLAM_FILE, TREE_FILE = "nav2_params.yaml", "slam_toolbox_params.yaml", "navigate_to_pose.xml"
LAUNCH_FILE, URDF_FILE, ROBOT_FILE = "bringup.launch.py", "robot.urdf", "robot.json"

PROGRESS = "controller_server.progress_checker"

MOVE_BASE_RULES: ParameterRules = {
    **same(SERVER, "controller_frequency"),
    **renamed(SERVER, controller_patience="failure_tolerance"),
    "oscillation_distance": ParameterRule(f"{PROGRESS}.required_movement_radius"),
    **without_effect("Nav2 recovers after the first plan that fails", "planner_patience", "max_planning_retries"),
    **without_effect(
        "plans of other drives are not used in Nav2", "reuse_plans", "reuse_tolerance", "reuse_bound"
    ),
}  # fmt: skip
"""What becomes of the parameters of ``move_base`` that are not used elsewhere in this package."""

ELSEWHERE = {
    "transform_tolerance": "transform_tolerance of both costmaps",
    "recovery_behavior_enabled": IN_TREE, "recovery_behaviors": IN_TREE, "clearing_rotation_allowed": IN_TREE,
    "conservative_reset_dist": IN_TREE,
}  # fmt: skip
"""Parameters of ``move_base`` that other parts of the set-up have."""

REPORTED = (
    "base_global_planner", "base_local_planner", "planner_frequency", "default_tolerance", "planner_timeout",
    "oscillation_timeout",
)  # fmt: skip
"""Parameters of ``move_base`` that are reported where they are translated."""

WAYPOINTS = "waypoint_follower"

WAYPOINT_RULES: ParameterRules = {
    **same(WAYPOINTS, "stop_on_failure"),
    "loop_rate": ParameterRule(f"{WAYPOINTS}.loop_rate", "a whole number in Nav2", lambda rate: max(1, round(rate))),
    "waypoint_pause_duration": ParameterRule(f"{WAYPOINTS}.wait_at_waypoint.waypoint_pause_duration"),
}

CAMERA, OCTOMAP = "depthimage_to_laserscan", "octomap_server"

CAMERA_RULES: ParameterRules = {
    **same(CAMERA, "scan_height", "scan_time", "range_min", "range_max"),
    **renamed(CAMERA, output_frame_id="output_frame"),
}

OCTOMAP_RULES: ParameterRules = {
    **same(
        OCTOMAP, "resolution", "frame_id", "base_frame_id", "filter_speckles", "latch", "filter_ground_plane",
        "occupancy_min_z", "occupancy_max_z", "min_x_size", "min_y_size", "sensor_model.max_range", "sensor_model.hit",
        "sensor_model.miss", "sensor_model.min", "sensor_model.max", "ground_filter.distance", "ground_filter.angle",
        "ground_filter.plane_distance",
        *(f"point_cloud_{end}_{axis}" for end in ("min", "max") for axis in "xyz"),
    ),
    **without_effect(
        "octomap_server has no such parameter", "max_blocks", "registration", "odom_frame_id", "tf_prefix"
    ),
}  # fmt: skip

ONLY_HERE = {
    "follow_path": "the robot follows paths itself: give its node the action follow_path in place of controller_server",
    "traffic": "Nav2 has no traffic of several robots",
    "teleop": "Nav2 has no driving by hand with leases",
    "explore": "explore_lite is no part of Nav2",
    "laser_proc": "run laser_proc of ROS beside Nav2, and remap its topic to /scan",
    "torso_detector": "Nav2 sees no people", "leg_detector": "Nav2 sees no people",
    "people_tracker": "Nav2 sees no people", "follow_person": "Nav2 sees no people",
    "robot_state_publisher": "the frame of the laser is in the URDF, or in the launch file",
}  # fmt: skip
"""Parts of a clone without a counterpart."""


@dataclass(frozen=True)
class Ros2Setup:
    """A set-up.

    Parameters
    ----------
    files : dict of str to bytes
        Contents by the names of the files.
    report : ImportReport
        What became of each parameter and zone; the source is the id of the robot.
    """

    files: dict[str, bytes]
    report: ImportReport


def export_ros2(robot: RobotToExport, release: Release) -> Ros2Setup:
    """Return a set-up of Nav2 and slam_toolbox that does what the clone of a robot does.

    Parameters
    ----------
    robot : RobotToExport
    release : Release
        Release of ROS 2 whose Nav2 is to run.
    """
    draft = SetupDraft(robot, release)
    masks = masks_of(robot.map, robot.given, robot.body.limits.max_vel_x, draft.report)
    add_amcl(draft)
    _add_navigator(draft)
    add_controller(draft)
    add_planner(draft)
    add_costmaps(draft, masks)
    add_behaviors(draft)
    tree = behavior_tree(draft)
    docks = add_docking(draft)
    _add_others(draft)
    add_mask_servers(draft, masks)
    add_slam(draft)
    _stamp_no_twists(draft)
    files = {
        NAV2_FILE: draft.yaml(*(name for name in draft.nodes() if name != SLAM)),
        SLAM_FILE: draft.yaml(SLAM),
        TREE_FILE: tree.encode(),
        ROBOT_FILE: json.dumps(robot.file, indent=2, ensure_ascii=False).encode() + b"\n",
    }
    grids = {
        "map": None if robot.map is None else robot.map.grid,
        "keepout_mask": masks.keepout,
        "speed_mask": masks.speed,
    }
    for name, grid in grids.items():
        if grid is not None:
            files[f"{name}.yaml"], files[f"{name}.pgm"] = save_map(grid, f"{name}.pgm")
    if docks is not None:
        files[DOCKS_FILE] = docks
    if robot.urdf is not None:
        files[URDF_FILE] = robot.urdf
    facts = LaunchFacts(robot, release, tuple(draft.nodes()), frozenset(files))
    files[LAUNCH_FILE] = launch_file(facts).encode()
    files["README.md"] = readme(facts, draft.report).encode()
    return Ros2Setup(files, draft.report)


def _add_navigator(draft: SetupDraft) -> None:
    for name, value in {"global_frame": "map", "robot_base_frame": "base_link", "odom_topic": "/odom"}.items():
        draft.put(f"bt_navigator.{name}", value)
    values = dict(draft.robot.in_use["move_base"])
    for name in (*REPORTED, *ELSEWHERE):
        value = values.pop(name)
        if name in ELSEWHERE and value is not None:
            draft.report.translated(f"move_base.{name}", f"{value!r}: {ELSEWHERE[name]}")
    draft.section("move_base", MOVE_BASE_RULES, values)


def _add_others(draft: SetupDraft) -> None:
    draft.put(f"{WAYPOINTS}.waypoint_task_executor_plugin", "wait_at_waypoint")
    draft.put(f"{WAYPOINTS}.wait_at_waypoint.plugin", "nav2_waypoint_follower::WaitAtWaypoint")
    draft.put(f"{WAYPOINTS}.wait_at_waypoint.enabled", True)
    draft.section(WAYPOINTS, WAYPOINT_RULES)
    draft.section(CAMERA, CAMERA_RULES)
    draft.section(OCTOMAP, OCTOMAP_RULES)
    for filter_name in (KEEPOUT_FILTER, SPEED_FILTER):
        if draft.robot.map is None or filter_name not in draft.robot.map.masks:
            draft.unused(filter_name, "the filter is not enabled, or has no mask")
    for name, why in ONLY_HERE.items():
        draft.unused(name, why)
    for name in _extras(draft.robot):
        draft.report.without_effect(name, "of PPaaS alone")


def _extras(robot: RobotToExport) -> list[str]:
    """Return the parts of the robot file that are for PPaaS alone."""
    given: dict[str, Any] = {name: robot.file.get(name) for name in ("cores", "labels", "properties", "description")}
    sections = [
        f"parameters.{name}" for name in ("recorder", "node_monitor") if name in robot.file.get("parameters", {})
    ]
    return [name for name, value in given.items() if value] + sections


def _stamp_no_twists(draft: SetupDraft) -> None:
    """Let velocities be a ``Twist`` in all releases, as robots of PPaaS take them; Humble has no other."""
    if not draft.release.is_humble:
        for node in ("controller_server", "behavior_server"):
            draft.put(f"{node}.enable_stamped_cmd_vel", False)
