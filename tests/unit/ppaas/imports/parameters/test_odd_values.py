"""Values of any type under any known name are taken or refused, and never make a robot file that its clone refuses."""

import datetime
import math
from collections.abc import Callable, Mapping

import pytest
import yaml

from ppaas.imports.parameters.amcl_rules import NAV2_RULES, ROS1_POSE, ROS1_RULES
from ppaas.imports.parameters.clone_check import refusal
from ppaas.imports.parameters.draft import Translation, robot_file
from ppaas.imports.parameters.ros1.amcl import import_amcl
from ppaas.imports.parameters.ros1.costmap_rules import COMMON_RULES, GLOBAL_RULES, LOCAL_RULES
from ppaas.imports.parameters.ros1.importing import import_ros1
from ppaas.imports.parameters.ros1.local_planner_rules import DYNAMIC_WINDOW, ELASTIC_BAND, TOP_SPEEDS, TRAJECTORY
from ppaas.imports.parameters.ros1.move_base_rules import GLOBAL_PLANNER, MOVE_BASE, NAVFN
from ppaas.imports.parameters.slam.gmapping import RULES as GMAPPING
from ppaas.imports.parameters.slam.gmapping import import_gmapping
from ppaas.imports.parameters.slam.slam_toolbox import import_slam_toolbox
from ppaas.imports.parameters.slam.slam_toolbox_rules import MAPPING_RULES, TOGETHER

VALUES = (
    None, "", "fast", "$(arg x)", True, 0, -1, -0.5, 1 << 70, math.inf, math.nan, [], [1, "a"], [[0, 0], [1]], {},
    datetime.date(2026, 1, 1), [None], "[[1, 2], [3, 4]]", "1e-3",
)  # fmt: skip

Importer = Callable[[bytes, str], Translation]

SECTIONS: Mapping[str, tuple[Importer, str, list[str]]] = {
    "slam_toolbox": (import_slam_toolbox, "slam_toolbox.ros__parameters", [*MAPPING_RULES, *TOGETHER]),
    "gmapping": (import_gmapping, "slam_gmapping", [*GMAPPING]),
    "amcl": (import_amcl, "amcl", [*ROS1_RULES, *ROS1_POSE]),
    "amcl of Nav2": (import_amcl, "amcl.ros__parameters", [*NAV2_RULES]),
    "move_base": (import_ros1, "move_base", ["base_local_planner", *MOVE_BASE, *COMMON_RULES]),
    "trajectory": (import_ros1, "TrajectoryPlannerROS", [*TRAJECTORY]),
    "dwa": (import_ros1, "DWAPlannerROS", [*DYNAMIC_WINDOW, *TOP_SPEEDS]),
    "teb": (import_ros1, "TebLocalPlannerROS", [*ELASTIC_BAND, *TOP_SPEEDS]),
    "navfn": (import_ros1, "NavfnROS", [*NAVFN]),
    "global_planner": (import_ros1, "GlobalPlanner", ["use_dijkstra", *GLOBAL_PLANNER]),
    "local_costmap": (import_ros1, "local_costmap", [*LOCAL_RULES]),
    "global_costmap": (import_ros1, "global_costmap", [*GLOBAL_RULES]),
}


@pytest.mark.parametrize("section", SECTIONS)
def test_values_of_any_type_leave_a_robot_file_that_builds(section: str) -> None:
    importer, path, names = SECTIONS[section]
    for start in range(3):
        # Each name has another value, so that faults are of many kinds, and few are at once.
        given = {name: VALUES[(start * 7 + index) % len(VALUES)] for index, name in enumerate(names)}
        content: object = given
        for above in reversed(path.split(".")):
            content = {above: content}
        into = importer(yaml.safe_dump(content).encode(), "f.yaml")
        assert len(into[1].entries) >= len(names) - 1
        assert refusal(robot_file([into], {"map": "office"}, refusal)) is None
