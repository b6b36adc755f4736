"""Parameter files of slam_toolbox: a robot that makes a map by ``grid_slam``, or is localized by ``amcl`` on one."""

from typing import TYPE_CHECKING

from ppaas.errors import InvalidParameter
from ppaas.imports.parameters.known_names import apply_known, is_left_open, values_of_node
from ppaas.imports.parameters.ros_yaml import GivenValue, read_parameter_file
from ppaas.imports.parameters.rules import put
from ppaas.imports.parameters.slam.slam_toolbox_rules import LOCALIZATION_RULES, MAPPING_RULES, TOGETHER
from ppaas.imports.parameters.values import numbers
from ppaas.imports.report import ImportReport
from ppaas.maps.new_map import NEW

if TYPE_CHECKING:
    from ppaas.imports.parameters.draft import Translation

MAPPING, LOCALIZATION, LIFELONG = "mapping", "localization", "lifelong"
"""Modes of slam_toolbox; the last one is another node of it, whose file says ``mode: mapping``."""

_LIFELONG = "lifelong_"
"""Begin of the names of the parameters of that node."""

_POSE = 3
"""Numbers of a pose: x, y [m], yaw [rad]."""

_MODE = "parameters.grid_slam.mode"


def import_slam_toolbox(content: bytes, name: str, new_map: str = "map") -> "Translation":
    """Translate a parameter file of slam_toolbox into a part of a robot file.

    A robot in the mode ``mapping`` makes a map; one with parameters of the lifelong node does so in that mode. A robot
    in the mode ``localization`` is localized by amcl: its file needs a published map.

    Parameters
    ----------
    content : bytes
    name : str
        Name of the file, for the report.
    new_map : str
        Id under which the map is to be published that the robot makes.

    Raises
    ------
    InvalidParameter
        The file cannot be read as parameters.
    """
    file = read_parameter_file(content)
    into: Translation = ({}, ImportReport(name))
    draft, report = into
    node, given = values_of_node(file, lambda each: "slam_toolbox" in each or "mapper" in each, report)
    together = {each: given.pop(each) for each in TOGETHER if each in given}
    prefix = f"{node}." if node else ""
    lifelong = any(each.startswith(_LIFELONG) for each in given)
    mode = _mode(together.pop("mode", None), f"{prefix}mode", lifelong=lifelong, into=into)
    if mode != LOCALIZATION:
        put(draft, "map", NEW + new_map)
    apply_known(LOCALIZATION_RULES if mode == LOCALIZATION else MAPPING_RULES, given, node, into)
    for each, value in together.items():
        _start(prefix + each, value, localizes=mode == LOCALIZATION, into=into)
    report.entries.sort(key=lambda entry: entry.line)
    return into


def _mode(mode: GivenValue | None, part: str, *, lifelong: bool, into: "Translation") -> str:
    """Return the mode of a robot, and write it into its file if it makes a map."""
    draft, report = into
    wanted, line = (MAPPING, 0) if mode is None else (str(mode.value), mode.line)
    if mode is not None and wanted not in (MAPPING, LOCALIZATION, LIFELONG):
        if not is_left_open(part, mode, report):
            report.refused(part, f"unknown mode {wanted!r}; known: {MAPPING}, {LOCALIZATION}, {LIFELONG}", line)
        mode, wanted = None, MAPPING
    if wanted == LOCALIZATION:
        report.translated(part, "the robot is localized by amcl on the published map of its file", line)
        return wanted
    put(draft, _MODE, LIFELONG if lifelong else wanted)
    if lifelong and wanted != LIFELONG:
        text = f"{_MODE} = {LIFELONG!r}: the file has parameters of the lifelong node"
        report.translated(part, text, line, to=_MODE)
    elif mode is not None:
        report.taken(part, _MODE, line, to=_MODE)
    return LIFELONG if lifelong else wanted


def _start(part: str, given: GivenValue, *, localizes: bool, into: "Translation") -> None:
    """Translate the pose graph with which slam_toolbox starts, or the pose in it."""
    draft, report = into
    name = part.rpartition(".")[2]
    if name == "map_file_name" and given.value in ("", None):
        report.without_effect(part, "no pose graph is named", given.line)
    elif name == "map_start_at_dock":
        report.without_effect(part, "a map is continued from its first key frame, unless a pose is given", given.line)
    elif is_left_open(part, given, report):
        return
    elif name == "map_file_name":
        continued = "publish the map with its pose graph, and set parameters.grid_slam.map_file_name to its id"
        where = "name a published map by --map" if localizes else continued
        report.refused(part, f"{given.value!r} is a file of the robot's disk: {where}", given.line)
    elif not localizes:
        report.without_effect(part, "the pose is in a map that is continued, and none is", given.line)
    else:
        try:
            pose = numbers(given.value, _POSE)
        except InvalidParameter as error:
            report.refused(part, str(error), given.line)
            return
        put(draft, "initial_pose", pose)
        report.translated(part, f"initial_pose = {pose}", given.line, to="initial_pose")
