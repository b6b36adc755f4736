"""Option files of cartographer, as far as they map: a robot that makes a map, or is localized on a published one."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from ppaas.imports.parameters.known_names import apply_once, refuse_unknown
from ppaas.imports.parameters.ros_yaml import GivenValue
from ppaas.imports.parameters.rules import ParameterRule, ParameterRules, put
from ppaas.imports.parameters.slam.cartographer_rules import (
    IN_SPACE,
    MAP_BUILDER,
    NODE,
    ON_A_MAP,
    POSE_GRAPH,
    TRAJECTORY,
    TRAJECTORY_2D,
)
from ppaas.imports.parameters.slam.lua_tables import read_lua_tables
from ppaas.imports.report import ImportReport
from ppaas.maps.new_map import NEW

if TYPE_CHECKING:
    from ppaas.imports.parameters.draft import Translation

ALIASES = {
    "options.map_builder": "MAP_BUILDER",
    "options.trajectory_builder": "TRAJECTORY_BUILDER",
    "options.sparse_pose_graph": "POSE_GRAPH",
    "MAP_BUILDER.pose_graph": "POSE_GRAPH",
    "MAP_BUILDER.sparse_pose_graph": "POSE_GRAPH",
    "SPARSE_POSE_GRAPH": "POSE_GRAPH",
    "MAP_BUILDER.trajectory_builder_2d": "TRAJECTORY_BUILDER_2D",
    "MAP_BUILDER.trajectory_builder_3d": "TRAJECTORY_BUILDER_3D",
    "TRAJECTORY_BUILDER.trajectory_builder_2d": "TRAJECTORY_BUILDER_2D",
    "TRAJECTORY_BUILDER.trajectory_builder_3d": "TRAJECTORY_BUILDER_3D",
}
"""Other names of the tables that cartographer's own files define."""

RULES: Mapping[str, ParameterRules] = {
    "options": NODE,
    "MAP_BUILDER": MAP_BUILDER,
    "TRAJECTORY_BUILDER": TRAJECTORY,
    "TRAJECTORY_BUILDER_2D": TRAJECTORY_2D,
    "POSE_GRAPH": POSE_GRAPH,
}
"""Rules by the table that has the options."""

DEFAULTS = frozenset(
    {"map_builder.lua", "trajectory_builder.lua", "trajectory_builder_2d.lua", "trajectory_builder_3d.lua",
     "pose_graph.lua", "sparse_pose_graph.lua"}
)  # fmt: skip
"""Files with the defaults of cartographer."""

_SPACE = ("TRAJECTORY_BUILDER_3D.", "MAP_BUILDER.use_trajectory_builder_3d")
_LOCALIZING = ("TRAJECTORY_BUILDER.pure_localization", "TRAJECTORY_BUILDER.pure_localization_trimmer")
_ON_A_MAP = "the robot is localized by amcl on the published map of its file"
_EVERY = ("POSE_GRAPH.optimize_every_n_nodes", "POSE_GRAPH.optimize_every_n_scans")
_CLOSING = "parameters.grid_slam.do_loop_closing"


def import_cartographer(content: bytes, name: str, new_map: str = "map") -> "Translation":
    """Translate an option file of cartographer into a part of a robot file.

    Parameters
    ----------
    content : bytes
    name : str
        Name of the file, for the report.
    new_map : str
        Id under which the map is to be published that the robot makes, unless it is localized on a published one.

    Raises
    ------
    InvalidParameter
        The file is not in Lua.
    """
    into: Translation = ({}, ImportReport(name))
    draft, report = into
    file = read_lua_tables(content, ALIASES, report)
    for included, line in file.included:
        _include(included, line, report)
    localizes = any(_localizes(path, given) for path, given in file.values.items())
    if not localizes:
        put(draft, "map", NEW + new_map)
    for path, given in file.values.items():
        _apply(path, given, localizes=localizes, into=into)
    report.entries.sort(key=lambda entry: entry.line)
    return into


def _include(name: str, line: int, report: ImportReport) -> None:
    part = f'include "{name}"'
    if name in DEFAULTS:
        report.without_effect(part, "its defaults are cartographer's; options that are not set have our defaults", line)
    else:
        report.refused(part, f"each file is read alone: give {name} by --cartographer before this one", line)


def _localizes(path: str, given: GivenValue) -> bool:
    return path.startswith(_LOCALIZING) and given.value is not False


def _apply(path: str, given: GivenValue, *, localizes: bool, into: "Translation") -> None:
    """Translate one option."""
    draft, report = into
    table, _, name = path.partition(".")
    if path.startswith(_SPACE) and given.value is True and table == "MAP_BUILDER":
        report.refused(path, IN_SPACE, given.line)
    elif path.startswith(_SPACE):
        report.without_effect(path, IN_SPACE, given.line)
    elif _localizes(path, given):
        report.translated(path, _ON_A_MAP, given.line)
    elif path in _EVERY and given.value == 0 and not localizes:
        put(draft, _CLOSING, value=False)
        report.translated(path, f"{_CLOSING} = False", given.line, to=_CLOSING)
    elif table not in RULES:
        report.without_effect(path, "cartographer does not read this table", given.line)
    else:
        _by_rule(path, _rule_of(RULES[table], name), given, localizes=localizes, into=into)


def _rule_of(rules: ParameterRules, name: str) -> ParameterRule | None:
    """Return the rule of an option, or the one of the table that it is in; None if no rule knows it."""
    while name:
        if name in rules:
            return rules[name]
        name = name.rpartition(".")[0]
    return None


def _by_rule(path: str, rule: ParameterRule | None, given: GivenValue, *, localizes: bool, into: "Translation") -> None:
    if rule is None:
        known = [f"{table}.{name}" for table, rules in RULES.items() for name in rules]
        refuse_unknown(path, path, known, given.line, into[1])
        return
    if localizes and rule.to:
        to = ON_A_MAP.get(rule.to, "")
        rule = ParameterRule(to, rule.text if to else "a robot on a published map makes none", rule.convert)
    apply_once(rule, path, given, into)
