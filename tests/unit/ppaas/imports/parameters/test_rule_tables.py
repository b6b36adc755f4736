"""Rule tables know all names of the releases, and write to places that a robot file has."""

import json
from collections.abc import Mapping
from pathlib import Path

import pytest

from ppaas.clone.robot_body import VoxelLayerParameters
from ppaas.clone.surroundings import LocalCostmapParameters
from ppaas.controllers.dwa import DwaParameters
from ppaas.controllers.mppi_parameters import MppiParameters
from ppaas.costmap.global_parameters import GlobalCostmapParameters, StaticLayerParameters
from ppaas.imports.parameters.amcl_rules import NAV2_RULES, ROS1_POSE, ROS1_RULES
from ppaas.imports.parameters.ros1.costmap_rules import COMMON_RULES, GLOBAL_RULES, LOCAL_RULES
from ppaas.imports.parameters.ros1.local_planner_rules import DYNAMIC_WINDOW, ELASTIC_BAND, TOP_SPEEDS, TRAJECTORY
from ppaas.imports.parameters.ros1.move_base_rules import CLEARING, GLOBAL_PLANNER, MOVE_BASE, NAVFN, ROTATING
from ppaas.imports.parameters.rules import ParameterRules
from ppaas.imports.parameters.slam.cartographer import RULES as CARTOGRAPHER
from ppaas.imports.parameters.slam.cartographer_rules import ON_A_MAP
from ppaas.imports.parameters.slam.gmapping import RULES as GMAPPING
from ppaas.imports.parameters.slam.slam_toolbox_rules import LOCALIZATION_RULES, MAPPING_RULES, TOGETHER
from ppaas.localization.parameters import AmclParameters
from ppaas.navigation.parameters import MoveBaseParameters
from ppaas.nodes.grid_slam.parameters import GridSlamParameters
from ppaas.recoveries.clear_costmap import ClearCostmapParameters
from ppaas.recoveries.rotate import RotateParameters
from robots.client.robot_file import RobotFile

RELEASES = json.loads(Path(__file__).with_name("release_names.json").read_text())

KNOWN: Mapping[str, list[set[str]]] = {
    "slam_toolbox": [{*MAPPING_RULES, *TOGETHER}, {*LOCALIZATION_RULES, *TOGETHER}],
    "gmapping": [set(GMAPPING)],
    "amcl": [{*ROS1_RULES, *ROS1_POSE}],
    "amcl_nav2": [set(NAV2_RULES)],
    "move_base": [{*MOVE_BASE, "base_local_planner"}],
    "DWAPlannerROS": [{*DYNAMIC_WINDOW, *TOP_SPEEDS}],
    "TrajectoryPlannerROS": [set(TRAJECTORY)],
    "TebLocalPlannerROS": [{*ELASTIC_BAND, *TOP_SPEEDS}],
    "NavfnROS": [set(NAVFN)],
    "GlobalPlanner": [{*GLOBAL_PLANNER, "use_dijkstra"}],
    "costmap_2d": [set(COMMON_RULES), set(GLOBAL_RULES), set(LOCAL_RULES)],
    "cartographer": [{f"{table}.{name}" for table, rules in CARTOGRAPHER.items() for name in rules}],
}

TABLES: dict[str, ParameterRules] = {
    "slam_toolbox, mapping": MAPPING_RULES, "slam_toolbox, localization": LOCALIZATION_RULES, "gmapping": GMAPPING,
    "amcl of ROS 1": ROS1_RULES, "amcl of Nav2": NAV2_RULES, "move_base": MOVE_BASE, "dwa": DYNAMIC_WINDOW,
    "trajectory": TRAJECTORY, "teb": ELASTIC_BAND, "navfn": NAVFN, "global_planner": GLOBAL_PLANNER,
    "global costmap": GLOBAL_RULES, "local costmap": LOCAL_RULES, **CARTOGRAPHER,
}  # fmt: skip

PLACES = {
    "grid_slam": GridSlamParameters, "amcl": AmclParameters, "move_base": MoveBaseParameters, "dwa": DwaParameters,
    "mppi": MppiParameters, "global_costmap": GlobalCostmapParameters, "local_costmap": LocalCostmapParameters,
    "static_layer": StaticLayerParameters, "voxel_layer": VoxelLayerParameters,
}  # fmt: skip


def is_below(name: str, known: set[str]) -> bool:
    """Return whether a name, or the table that it is in, is known."""
    return any(".".join(name.split(".")[:depth]) in known for depth in range(1, name.count(".") + 2))


@pytest.mark.parametrize("program", RELEASES)
def test_all_names_of_the_releases_are_known(program: str) -> None:
    names = {name for source in RELEASES[program] for name in source["names"]}
    assert len(names) >= 5
    for known in KNOWN[program]:
        assert {name for name in names if not is_below(name, known)} == set()


@pytest.mark.parametrize("table", TABLES)
def test_each_rule_writes_to_a_place_that_exists_or_says_why_not(table: str) -> None:
    for name, rule in TABLES[table].items():
        if not rule.to:
            assert rule.text, name
            continue
        section, _, rest = rule.to.partition(".")
        if section != "parameters":
            assert rule.to in RobotFile.__struct_fields__
            continue
        node, _, field = rest.partition(".")
        if node in PLACES:
            assert field in PLACES[node].__struct_fields__, rule.to
        else:
            assert (node, field) in {("navfn", "allow_unknown"), ("dijkstra", "allow_unknown")}


def test_the_places_on_a_published_map_and_of_recoveries_exist() -> None:
    for place in ON_A_MAP.values():
        assert place.rpartition(".")[2] in AmclParameters.__struct_fields__
    for rules, fields in ((CLEARING, ClearCostmapParameters), (ROTATING, RotateParameters)):
        assert {rule.to for rule in rules.values() if rule.to} <= set(fields.__struct_fields__)
