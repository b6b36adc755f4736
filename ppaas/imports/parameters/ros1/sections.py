"""Sections of parameter files of ROS 1: which program reads a parameter, whatever file and namespace it is in."""

from collections.abc import Iterable, Mapping

import msgspec

from ppaas.imports.parameters.amcl_rules import ROS1_POSE, ROS1_RULES
from ppaas.imports.parameters.ros1.costmap_rules import COMMON_RULES
from ppaas.imports.parameters.ros1.local_planner_rules import DYNAMIC_WINDOW, ELASTIC_BAND, TOP_SPEEDS, TRAJECTORY
from ppaas.imports.parameters.ros1.move_base_rules import (
    GLOBAL_PLANNER,
    MOVE_BASE,
    NAVFN,
    PLUGIN_LISTS,
    VELOCITY_SMOOTHER,
)
from ppaas.imports.parameters.ros_yaml import GivenValue, ParameterFile
from ppaas.imports.parameters.rules import ParameterRules
from ppaas.imports.parameters.slam.gmapping import RULES as GMAPPING

MOVE_BASE_NAMES = ("move_base", "move_base_node", "move_base_flex")
"""Names of the node, which its parameters may be below."""

AMCL, SLAM, COMMON, LOCAL_PLANNER = "amcl", "gmapping", "costmap", "base_local_planner"
SMOOTHER = "velocity_smoother"
"""Sections of parameters that may be outside any, in the file of their program."""

_FLAT: Mapping[str, Iterable[str]] = {
    AMCL: (*ROS1_RULES, *ROS1_POSE),
    SLAM: GMAPPING,
    "TebLocalPlannerROS": (*ELASTIC_BAND, *TOP_SPEEDS),
    "DWAPlannerROS": (*DYNAMIC_WINDOW, *TOP_SPEEDS),
    "TrajectoryPlannerROS": TRAJECTORY,
    SMOOTHER: VELOCITY_SMOOTHER,
}
"""Names of the parameters that a program reads, if its file is loaded into its own namespace."""


_PROGRAMS: Mapping[str, Iterable[str]] = {
    **_FLAT,
    "costmap_2d": COMMON_RULES,
    "move_base": MOVE_BASE,
    "NavfnROS": NAVFN,
    "GlobalPlanner": GLOBAL_PLANNER,
}
"""Names of the parameters of each program."""

NAMED = frozenset(
    (*MOVE_BASE_NAMES, *_FLAT, "slam_gmapping", "local_costmap", "global_costmap", "NavfnROS", "GlobalPlanner")
)
"""Names of sections and nodes, which a namespace may precede."""


class Section(msgspec.Struct, frozen=True):
    """Parameters of one program in one file.

    Parameters
    ----------
    name : str
        ``move_base``, ``local_costmap``, ``DWAPlannerROS``, ``amcl``, …; empty for common ones of move_base.
    values : dict
        Values by their names in the section.
    prefix : str
        What precedes these names in the file.
    """

    name: str
    values: dict[str, GivenValue]
    prefix: str

    @property
    def node(self) -> str:
        """The section as it is written in the file."""
        return self.prefix.rstrip(".")


def sections_of(file: ParameterFile) -> list[Section]:
    """Return the sections of a file, of which the namespace of move_base is left out.

    Parameters outside any section are those of the program that knows most of them.
    """
    found: dict[tuple[str, str], dict[str, GivenValue]] = {}
    flat: dict[str, GivenValue] = {}
    for node, values in file.nodes.items():
        *above, last = node.split("/")
        for name, value in values.items():
            prefix, _, rest = f"{last}.{name}".lstrip(".").partition(".")
            space = "".join(f"{each}/" for each in above)
            if prefix not in NAMED and rest.partition(".")[0] in NAMED:  # the namespace of a robot
                space, (prefix, _, rest) = f"{space}{prefix}/", rest.partition(".")
            if prefix in MOVE_BASE_NAMES and rest:
                space, (prefix, _, rest) = f"{space}{prefix}/", rest.partition(".")
            if rest:
                found.setdefault((prefix, space), {})[rest] = value
            else:
                flat[prefix] = value
    named = [Section(name, values, f"{space}{name}.") for (name, space), values in found.items()]
    return ([_flat_section(flat)] if flat else []) + named


def as_of_move_base(files: list[list[Section]]) -> list[list[Section]]:
    """Return the sections of files, of which those of move_base_flex's plug-ins get the names of their types."""
    every = [section.values for sections in files for section in sections]
    lists = [values[key].value for values in every for key in PLUGIN_LISTS if key in values]
    types = {name: kind for found in lists for name, kind in plugins_of(found)}
    return [
        [Section(last_part(types.get(each.name, each.name)), each.values, each.prefix) for each in sections]
        for sections in files
    ]


def plugins_of(value: object) -> list[tuple[str, str]]:
    """Return the names and types of a list of plug-ins."""
    given = value if isinstance(value, list) else []
    known = [each for each in given if isinstance(each, dict) and {"name", "type"} <= each.keys()]
    return [(str(each["name"]), str(each["type"])) for each in known]


def last_part(name: object) -> str:
    """Return a plug-in's name without its package."""
    return str(name).replace("::", "/").rpartition("/")[2]


def _flat_section(flat: dict[str, GivenValue]) -> Section:
    """Return the section of parameters outside any, by the program that knows most of their names."""
    names = flat.keys()
    best, known = "", len(names & {*MOVE_BASE, *COMMON_RULES, LOCAL_PLANNER, *PLUGIN_LISTS})
    for section, rules in _FLAT.items():
        count = len(names & set(rules))
        if count > known:
            best, known = section, count
    return Section(best, flat, "")


def layer_rule_name(name: str, rules: ParameterRules) -> str:
    """Return the name of a costmap's rule: its last part, if the parameter belongs to a layer or a source."""
    return name if name in rules else name.rpartition(".")[2]


def readers_of(name: str) -> str:
    """Return the programs that read a parameter of a name, as text; empty if none is known."""
    return " or ".join(program for program, names in _PROGRAMS.items() if name in names)
