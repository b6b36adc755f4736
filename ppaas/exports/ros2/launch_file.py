"""Launch file of a set-up, in Python, and the page that describes the set-up."""

import json
from dataclasses import dataclass

from ppaas.exports.ros2.releases import Release
from ppaas.exports.ros2.robot import RobotToExport
from ppaas.imports.report import ImportOutcome, ImportReport


@dataclass(frozen=True)
class LaunchFacts:
    """What the launch file starts.

    Parameters
    ----------
    robot : RobotToExport
    release : Release
    nodes : tuple of str
        Names of the nodes that have parameters.
    files : frozenset of str
        Names of the files of the set-up.
    """

    robot: RobotToExport
    release: Release
    nodes: tuple[str, ...]
    files: frozenset[str]

    @property
    def has_amcl(self) -> bool:
        """Whether amcl localizes the robot, which else does so itself."""
        return "amcl" in self.nodes

    @property
    def servers(self) -> dict[str, tuple[str, str]]:
        """Package and program of each node with a life cycle, beside map server and localization, by its name."""
        servers: dict[str, tuple[str, str]] = {}
        for mask in ("keepout", "speed"):  # first: the filters of the costmaps wait for them
            if f"{mask}_filter_mask_server" in self.nodes:
                servers[f"{mask}_filter_mask_server"] = ("nav2_map_server", "map_server")
                servers[f"{mask}_costmap_filter_info_server"] = ("nav2_map_server", "costmap_filter_info_server")
        if "docking_server" in self.nodes:
            servers["docking_server"] = ("opennav_docking", "opennav_docking")
        return servers | {
            "controller_server": ("nav2_controller", "controller_server"),
            "planner_server": ("nav2_planner", "planner_server"),
            "behavior_server": ("nav2_behaviors", "behavior_server"),
            "bt_navigator": ("nav2_bt_navigator", "bt_navigator"),
            "waypoint_follower": ("nav2_waypoint_follower", "waypoint_follower"),
        }


_TEMPLATE = '''"""Starts Nav2 for the robot {name} (ROS 2 {release}), by the parameters in this folder.

Written by `ppaas export ros2`. With slam:=true, slam_toolbox makes a new map; otherwise {localizer}.
"""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.conditions import IfCondition, UnlessCondition
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

HERE = Path(__file__).resolve().parent
PARAMETERS = str(HERE / "nav2_params.yaml")

SERVERS = {servers}
"""Nodes with a life cycle: package, program, and parameters that name files of this folder."""


def generate_launch_description():
    """Return what is started."""
    slam = LaunchConfiguration("slam")
    clock = {{"use_sim_time": ParameterValue(LaunchConfiguration("use_sim_time"), value_type=bool)}}

    def node(package, executable, name, *parameters, **options):
        return Node(
            package=package, executable=executable, name=name, output="screen",
            parameters=[*parameters, clock], **options,
        )

    def manager(name, nodes, **options):
        parameters = {{"autostart": True, "node_names": nodes}}
        return node("nav2_lifecycle_manager", "lifecycle_manager", name, parameters, **options)

    def server(name):
        package, executable, files = SERVERS[name]
        parameters = {{key: str(HERE / file) for key, file in files.items()}}
        return node(package, executable, name, PARAMETERS, parameters)

    slam_toolbox = Path(get_package_share_directory("slam_toolbox"), "launch", "online_async_launch.py")
    slam_arguments = {{
        "slam_params_file": str(HERE / "slam_toolbox_params.yaml"),
        "use_sim_time": LaunchConfiguration("use_sim_time"),
    }}
    return LaunchDescription([
        DeclareLaunchArgument("slam", default_value="{slam}", description="make a new map"),
        DeclareLaunchArgument("use_sim_time", default_value="false", description="take the clock of a simulation"),
{frames}        IncludeLaunchDescription(
            PythonLaunchDescriptionSource(str(slam_toolbox)),
            launch_arguments=slam_arguments.items(),
            condition=IfCondition(slam),
        ),
{localization}        *(server(name) for name in SERVERS),
        manager("lifecycle_manager_navigation", list(SERVERS)),
{sensors}    ])
'''

_MAP = """        node(
            "nav2_map_server", "map_server", "map_server", {"yaml_filename": str(HERE / "map.yaml")},
            condition=UnlessCondition(slam),
        ),
"""

_AMCL = """        node("nav2_amcl", "amcl", "amcl", PARAMETERS, condition=UnlessCondition(slam)),
        manager("lifecycle_manager_localization", ["map_server", "amcl"], condition=UnlessCondition(slam)),
"""

_NO_AMCL = """        manager("lifecycle_manager_localization", ["map_server"], condition=UnlessCondition(slam)),
"""

_URDF = """        node(
            "robot_state_publisher", "robot_state_publisher", "robot_state_publisher",
            {"robot_description": (HERE / "robot.urdf").read_text(encoding="utf-8")},
        ),
"""

_CAMERA = """        node(
            "depthimage_to_laserscan", "depthimage_to_laserscan_node", "depthimage_to_laserscan", PARAMETERS,
            remappings=[("depth", "camera/depth/image_raw"), ("depth_camera_info", "camera/depth/camera_info")],
        ),
"""

_OCTOMAP = """        node("octomap_server", "octomap_server_node", "octomap_server", PARAMETERS),
"""


def launch_file(facts: LaunchFacts) -> str:
    """Return the launch file."""
    sensors = (_CAMERA if "depthimage_to_laserscan" in facts.nodes else "") + (
        _OCTOMAP if "octomap_server" in facts.nodes else ""
    )
    return _TEMPLATE.format(
        name=_in_docstring(facts.robot.name),
        release=facts.release.value,
        servers=_servers(facts),
        slam="false" if "map.yaml" in facts.files else "true",
        frames=_URDF if "robot.urdf" in facts.files else _laser(facts.robot),
        localizer="amcl localizes the robot" if facts.has_amcl else "the robot localizes itself",
        localization=_MAP + (_AMCL if facts.has_amcl else _NO_AMCL) if "map.yaml" in facts.files else "",
        sensors=sensors,
    )


def _in_docstring(name: str) -> str:
    """Return a name of a robot without what ends or escapes a docstring."""
    return "".join(character for character in name if character.isalnum() or character in "-_.: ")


def _servers(facts: LaunchFacts) -> str:
    lines = []
    for name, (package, executable) in facts.servers.items():
        files = {}
        if name == "bt_navigator":
            files = {"default_nav_to_pose_bt_xml": "navigate_to_pose.xml"}
        elif name == "docking_server":
            files = {"dock_database": "docks.yaml"}
        elif name.endswith("_filter_mask_server"):
            files = {"yaml_filename": f"{name.partition('_')[0]}_mask.yaml"}
        lines.append(f'    "{name}": ("{package}", "{executable}", {files}),'.replace("'", '"'))
    return "\n".join(("{", *lines, "}"))


def _laser(robot: RobotToExport) -> str:
    """Return the node that publishes where the laser is, of a robot without a URDF."""
    x, y, yaw = robot.body.laser
    frame = robot.in_use["robot_state_publisher"]["laser_frame"] or robot.body.laser_frame
    place = f'"--x", "{x:g}", "--y", "{y:g}", "--yaw", "{yaw:g}"'
    return f"""        Node(
            package="tf2_ros", executable="static_transform_publisher", name="laser_frame",
            arguments=[{place}, "--frame-id", "base_link", "--child-frame-id", {json.dumps(frame)}],
        ),
"""


_README = """# {name} on Nav2

Written by `ppaas export ros2`: a set-up of Nav2 and slam_toolbox for ROS 2 {title} that does what the clone of the
robot `{name}` does in the cloud. Nothing in it needs PPaaS.

```sh
sudo apt install {packages}
ros2 launch ./bringup.launch.py
```

The robot publishes `/odom`, the transform `odom` → `base_link` on `/tf`, and `/scan`; it takes `/cmd_vel` (`Twist`).
{localized}

```sh
ros2 launch ./bringup.launch.py slam:=true
ros2 run nav2_map_server map_saver_cli -f map
```

The first makes a new map, the second saves it as `map.yaml` and `map.pgm`. Send the robot to a pose:

```sh
ros2 action send_goal /navigate_to_pose nav2_msgs/action/NavigateToPose \\
    "{{pose: {{header: {{frame_id: map}}, pose: {{position: {{x: 1.0}}, orientation: {{w: 1.0}}}}}}}}"
```

| file | what it is |
|---|---|
{files}

## What could not be expressed

{missing}
"""

_FILES = {
    "nav2_params.yaml": "parameters of all nodes of Nav2",
    "slam_toolbox_params.yaml": "parameters of slam_toolbox",
    "navigate_to_pose.xml": "behaviour tree: planning again, and recovery in the order of Move Base",
    "map.yaml": "the map, with `map.pgm`",
    "keepout_mask.yaml": "keep-out zones, and the robot's keepout mask",
    "speed_mask.yaml": "speed limits in percent of the robot's maximum speed",
    "docks.yaml": "the docks of the map, for Nav2's docking server",
    "robot.urdf": "its URDF",
    "robot.json": "the robot file of PPaaS that all this was made of",
    "bringup.launch.py": "starts it all",
}


def readme(facts: LaunchFacts, report: ImportReport) -> str:
    """Return the page of a set-up: its commands, its files, and what could not be expressed."""
    distribution = facts.release.value
    optional = [name for name in ("depthimage_to_laserscan", "octomap_server") if name in facts.nodes]
    packages = ["navigation2", "slam-toolbox", "robot-state-publisher", *(name.replace("_", "-") for name in optional)]
    if "docking_server" in facts.nodes and facts.release.is_humble:
        packages.append("opennav-docking")  # a part of navigation2 in later releases
    missing = [
        f"- `{entry.part}`: {entry.text}"
        for entry in report.entries
        if entry.outcome in (ImportOutcome.NO_EFFECT, ImportOutcome.REFUSED)
    ]
    by_amcl, by_itself = "amcl localizes it on `map.yaml`, from its initial pose.", "It localizes itself on `map.yaml`."
    on_map = by_amcl if facts.has_amcl else by_itself
    written = {*facts.files, "bringup.launch.py"}
    return _README.format(
        name=facts.robot.name,
        title=distribution.title(),
        packages=" ".join(f"ros-{distribution}-{name}" for name in packages),
        localized=on_map if "map.yaml" in facts.files else "slam_toolbox makes its map.",
        files="\n".join(f"| `{file}` | {what} |" for file, what in _FILES.items() if file in written),
        missing="\n".join(missing) or "Nothing: every parameter has its counterpart.",
    )
