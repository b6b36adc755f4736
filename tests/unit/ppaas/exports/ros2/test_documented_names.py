"""All names in the files of a set-up are names that Nav2 and slam_toolbox document."""

import json
import tomllib
from collections import defaultdict
from collections.abc import Iterator, Mapping
from typing import Any

import msgspec
import pytest
import yaml

from ppaas.exports.ros2.localization import OF_THE_MATCHER
from ppaas.exports.ros2.releases import Release
from ppaas.imports.parameters.ros_yaml import ROS2_KEY
from ppaas.nodes.grid_slam.parameters import WITHOUT_EFFECT, GridSlamParameters
from tests.support.sources import ROOT
from tests.unit.ppaas.exports.ros2.test_setup import dock, exported, map_of, zone

FOLDER = ROOT / "tests" / "unit" / "ppaas" / "imports" / "parameters"
LISTS, OF_SLAM = FOLDER / "nav2" / "documented.toml", FOLDER / "release_names.json"

NOT_LISTED = {
    "opennav_docking::SimpleNonChargingDock": "docking_threshold",
    "nav2_controller::StoppedGoalChecker": "trans_stopped_velocity rot_stopped_velocity",
    "nav2_costmap_2d::ObstacleLayer": "observation_sources",
    "nav2_theta_star_planner::ThetaStarPlanner": "how_many_corners w_euc_cost w_traversal_cost w_heuristic_cost "
    "allow_unknown use_final_approach_orientation terminal_checking_interval",
}
"""Names by the plug-in's source code: its page names those of the class that it extends, or none."""

EXTENDS = {
    "opennav_docking::SimpleNonChargingDock": "opennav_docking::SimpleChargingDock",
    "nav2_controller::StoppedGoalChecker": "nav2_controller::SimpleGoalChecker",
}

DEFAULTS = msgspec.structs.asdict(GridSlamParameters())

OF_HUMBLE = {"behavior_server": {"costmap_topic", "footprint_topic", "global_frame"}}
"""Names that later releases do not have, and their pages no more."""

FILTERS = {"topic_name", "yaml_filename", "type", "filter_info_topic", "mask_topic", "base", "multiplier"}
"""Names of ``map_server`` and ``costmap_filter_info_server``."""


def documented() -> tuple[dict[str, set[str]], dict[str, set[str]]]:
    """Return the names of nodes, and of plug-ins relative to their section."""
    nodes: dict[str, set[str]] = defaultdict(set)
    plugins: dict[str, set[str]] = defaultdict(set)
    for source in tomllib.loads(LISTS.read_text(encoding="utf-8"))["source"]:
        into = plugins[source["plugin"]] if "plugin" in source else nodes[source["node"]]
        for kind, names in source.items():
            if kind == "names":
                into.update(names.split())
            elif kind == "of_sources":
                into.update(f"scan.{name}" for name in names.split())
            elif kind.startswith("of_"):
                into.update(names.split())
    for plugin, more in NOT_LISTED.items():
        plugins[plugin].update(more.split(), plugins.get(EXTENDS.get(plugin, ""), set()))
    return nodes, plugins


def leaves(table: Mapping[str, Any], above: str = "") -> Iterator[str]:
    for name, value in table.items():
        if isinstance(value, dict):
            yield from leaves(value, f"{above}{name}.")
        else:
            yield above + name


def unknown(table: dict[str, Any], names: set[str], plugins: Mapping[str, set[str]]) -> set[str]:
    """Return the names in the parameters of a node that are in no list."""
    found = set()
    for name, value in table.items():
        if isinstance(value, dict) and "plugin" in value:
            own = plugins[value["plugin"].replace("/", "::")]
            found |= {f"{name}.{each}" for each in leaves(value) if each != "plugin" and each not in own}
        else:
            found |= set(leaves({name: value})) - names
    return found


@pytest.mark.parametrize("release", Release)
@pytest.mark.parametrize(
    ("controller", "planner"),
    [("dwa", "dijkstra"), ("mppi", "lattice"), ("pure_pursuit", "theta_star"), ("dwa", "astar")],
)
def test_all_names_are_documented(release: Release, controller: str, planner: str) -> None:
    marks = dock("a", 1.0, dock_type="home"), dock("b", 2.0, charges=False, dock_type="reverse")
    zones = map_of(zone("keep_out", 0.0), zone("speed_limit", 2.0, percent=50), *marks)
    types = {
        "docking_server": {"dock_types": {"home": {"detection": "pose"}, "reverse": {"dock_direction": "backward"}}}
    }
    file = {"base_local_planner": controller, "base_global_planner": planner, "parameters": types}
    document = yaml.safe_load(exported(file, zones, release).files["nav2_params.yaml"])
    nodes, plugins = documented()
    for node, content in document.items():
        names = nodes[node] | FILTERS if node.endswith("_server") and "filter" in node else nodes[node]
        names = names | OF_HUMBLE.get(node, set()) if release is Release.HUMBLE else names
        assert names, node
        table = (content[node] if node.endswith("costmap") else content)[ROS2_KEY]
        assert unknown(table, names, plugins) == set(), node


def test_all_names_of_slam_toolbox_are_documented() -> None:
    given = {name: value for name, value in DEFAULTS.items() if name in OF_THE_MATCHER or name.startswith("lifelong")}
    lifelong = dict.fromkeys(WITHOUT_EFFECT, 0.5) | {"lifelong_search_use_tree": True}
    setup = exported({"map": "new:office-2", "parameters": {"grid_slam": given | lifelong}})
    document = yaml.safe_load(setup.files["slam_toolbox_params.yaml"])
    listed = {name for source in json.loads(OF_SLAM.read_text("utf-8"))["slam_toolbox"] for name in source["names"]}
    names = set(document["slam_toolbox"][ROS2_KEY])
    assert len(names) > 25
    assert names - listed == set()
