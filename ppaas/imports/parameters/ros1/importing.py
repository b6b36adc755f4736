"""Parameter files of ROS 1's navigation: move_base with its costmaps, planners and recovery behaviours, and amcl."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from ppaas.controllers.registry import CONTROLLERS
from ppaas.errors import InvalidParameter
from ppaas.imports.parameters.known_names import (
    apply_known,
    apply_once,
    is_left_open,
    refuse_unknown,
    report_repeated,
)
from ppaas.imports.parameters.launch_files import read_parameters
from ppaas.imports.parameters.ros1.amcl import apply_amcl
from ppaas.imports.parameters.ros1.costmap_rules import BOTH, COMMON_RULES, GLOBAL_RULES, LOCAL_RULES, RANGES
from ppaas.imports.parameters.ros1.local_planner_rules import DYNAMIC_WINDOW, ELASTIC_BAND, TOP_SPEEDS, TRAJECTORY
from ppaas.imports.parameters.ros1.move_base_rules import (
    GLOBAL_PLANNER,
    MOVE_BASE,
    NAVFN,
    PLUGIN_LISTS,
    VELOCITY_SMOOTHER,
    rules_of_recovery,
)
from ppaas.imports.parameters.ros1.sections import (
    AMCL,
    LOCAL_PLANNER,
    MOVE_BASE_NAMES,
    SLAM,
    SMOOTHER,
    Section,
    as_of_move_base,
    last_part,
    layer_rule_name,
    plugins_of,
    readers_of,
    sections_of,
)
from ppaas.imports.parameters.ros_yaml import GivenValue, ParameterFile
from ppaas.imports.parameters.rules import ParameterRule, ParameterRules, put
from ppaas.imports.parameters.slam.gmapping import apply_gmapping
from ppaas.imports.parameters.values import number
from ppaas.imports.report import ImportOutcome, ImportReport
from ppaas.navigation.parameters import AGGRESSIVE, CONSERVATIVE, ROTATE
from ppaas.recoveries.registry import RECOVERIES

if TYPE_CHECKING:
    from ppaas.imports.parameters.draft import Translation

LOCAL_PLANNERS: Mapping[str, tuple[str, ParameterRules]] = {
    "TrajectoryPlannerROS": ("dwa", TRAJECTORY),
    "DWAPlannerROS": ("dwa", DYNAMIC_WINDOW),
    "TebLocalPlannerROS": ("mppi", ELASTIC_BAND),
}
"""Plug-in and rules of each local planner, by the last part of its name."""

DEFAULT = "TrajectoryPlannerROS"
"""Local planner of move_base if none is named."""

GLOBAL_PLANNER_FIELD = "base_global_planner"

_NONE = ParameterRule()
_COSTMAPS = {"local_costmap": LOCAL_RULES, "global_costmap": GLOBAL_RULES}
_SECTIONS = (*MOVE_BASE_NAMES, *_COSTMAPS, *LOCAL_PLANNERS, "NavfnROS", "GlobalPlanner", AMCL)


def import_ros1(content: bytes, name: str, new_map: str = "map") -> "Translation":
    """Translate one parameter file of ROS 1 into a part of a robot file; see `import_ros1_files`."""
    return import_ros1_files([(content, name)], new_map)[0]


def import_ros1_files(files: Sequence[tuple[bytes, str]], new_map: str = "map") -> "list[Translation]":
    """Translate the parameter files and launch files of a robot of ROS 1, of which each becomes a part of a robot file.

    Which local planner drives, and which recovery behaviours there are, may be in another file than their parameters.

    Parameters
    ----------
    files : sequence of (bytes, str)
        Contents and names.
    new_map : str
        Id under which the map is to be published that the robot makes, if a file has parameters of gmapping.

    Raises
    ------
    InvalidParameter
        A file cannot be read as parameters, or is one of ROS 2.
    """
    read = [_read(content, ImportReport(name)) for content, name in files]
    for file, report in read:
        if file.is_ros2:
            raise InvalidParameter(f"{report.source} has ros__parameters, and so is a file of ROS 2: not for --ros1")
    sections = as_of_move_base([sections_of(file) for file, _ in read])
    robot = _Robot([section for each in sections for section in each], new_map)
    translations: list[Translation] = []
    for (file, report), each in zip(read, sections, strict=True):
        into: Translation = ({}, report)
        report_repeated(file, report)
        for section in each:
            robot.translate(section, into)
        report.entries.sort(key=lambda entry: entry.line)
        translations.append(into)
    _drop_radius(translations)
    return translations


def _read(content: bytes, report: ImportReport) -> tuple[ParameterFile, ImportReport]:
    return read_parameters(content, report), report


class _Robot:
    """What the sections of all files say together: the planners and the recovery behaviours.

    Parameters
    ----------
    sections : list of Section
    new_map : str
    """

    def __init__(self, sections: list[Section], new_map: str) -> None:
        self._new_map = new_map
        named = [chosen for each in sections if not each.name for chosen in _local_planners(each.values)]
        present = [section.name for section in sections if section.name in LOCAL_PLANNERS]
        self._is_named = bool(named)
        self._planner = last_part(named[-1]) if named else DEFAULT if DEFAULT in present else (present or [""])[0]
        self._behaviors = _behaviors(sections)
        self._layers = _layers(sections)
        searches = [each.values.get("use_dijkstra") for each in sections if each.name == "GlobalPlanner"]
        self._global = "astar" if any(each is not None and each.value is False for each in searches) else "dijkstra"

    def translate(self, section: Section, into: "Translation") -> None:
        """Translate a section into the draft of its file."""
        name = section.name
        if name in LOCAL_PLANNERS:
            self._local_planner(section, into)
        elif name in _COSTMAPS:
            _costmap(_COSTMAPS[name], section, into)
        elif name in ("NavfnROS", "GlobalPlanner"):
            self._global_planner(section, into)
        elif name == AMCL:
            apply_amcl(section.values, section.node, into)
        elif SLAM in name:
            apply_gmapping(section.values, section.node, into, self._new_map)
        elif name == SMOOTHER:
            _plain(VELOCITY_SMOOTHER, section, into)
        elif name in self._behaviors:
            self._recovery(section, into)
        elif not name:
            self._move_base(section, into)
        elif any(layer_rule_name(each, COMMON_RULES) in COMMON_RULES for each in section.values):
            _costmap(COMMON_RULES, section, into)
        else:
            self._unknown(section, into[1])

    def _unknown(self, section: Section, report: ImportReport) -> None:
        line = min(value.line for value in section.values.values())
        if section.name in self._layers:
            report.without_effect(section.node, f"of {self._layers[section.name]}, which is not known", line)
        else:
            refuse_unknown(section.node, section.name, _SECTIONS, line, report)

    def _move_base(self, section: Section, into: "Translation") -> None:
        """Translate parameters of move_base, and those common to its costmaps, which stand beside them."""
        own = {}
        for name, given in section.values.items():
            part = section.prefix + name
            if name in PLUGIN_LISTS:
                self._first_plugin(PLUGIN_LISTS[name], part, given, into)
            elif name == LOCAL_PLANNER:
                self._name_planner(part, given, into)
            elif name == GLOBAL_PLANNER_FIELD:
                self._name_global_planner(part, given, into)
            elif name in COMMON_RULES and name not in MOVE_BASE:
                _costmap_value(COMMON_RULES, part, given, into)
            else:
                own[name] = given
        _apply({**COMMON_RULES, **MOVE_BASE}, own, section, into)

    def _first_plugin(self, field: str, part: str, given: GivenValue, into: "Translation") -> None:
        """Take the first plug-in of a list of move_base_flex as the planner that move_base names."""
        plugins = plugins_of(given.value)
        if not plugins:
            into[1].refused(part, "it must be a list of {name: …, type: …}", given.line)
            return
        name = self._name_planner if field == LOCAL_PLANNER else self._name_global_planner
        name(part, GivenValue(plugins[0][1], given.line), into)
        for plugin, _ in plugins[1:]:
            into[1].without_effect(f"{part} {plugin}", "the first plug-in of the list counts", given.line)

    def _name_global_planner(self, part: str, given: GivenValue, into: "Translation") -> None:
        if last_part(given.value) == "GlobalPlanner":
            put(into[0], GLOBAL_PLANNER_FIELD, self._global)
            text = f"{GLOBAL_PLANNER_FIELD} = {self._global!r}"
            into[1].translated(part, text, given.line, to=GLOBAL_PLANNER_FIELD)
        elif not is_left_open(part, given, into[1]):
            apply_once(MOVE_BASE[GLOBAL_PLANNER_FIELD], part, given, into)

    def _name_planner(self, part: str, given: GivenValue, into: "Translation") -> None:
        draft, report = into
        if is_left_open(part, given, report):
            return
        name = str(given.value)
        own = LOCAL_PLANNERS[last_part(name)][0] if last_part(name) in LOCAL_PLANNERS else CONTROLLERS.own_name(name)
        if own in CONTROLLERS:
            put(draft, LOCAL_PLANNER, own)
            report.translated(part, f"{LOCAL_PLANNER} = {own!r}", given.line, to=LOCAL_PLANNER)
            return
        near = report.nearest_name(last_part(name), LOCAL_PLANNERS)
        known = f"did you mean {near!r}?" if near else f"known: {', '.join(LOCAL_PLANNERS)}"
        report.refused(part, f"there is no local planner {name!r}; {known}", given.line)

    def _local_planner(self, section: Section, into: "Translation") -> None:
        draft, report = into
        if section.name != self._planner:
            for name, given in section.values.items():
                report.without_effect(section.prefix + name, f"the robot drives with {self._planner}", given.line)
            return
        own, rules = LOCAL_PLANNERS[section.name]
        if not self._is_named:
            put(draft, LOCAL_PLANNER, own)
            report.translated(section.node, f"{LOCAL_PLANNER} = {own!r}", to=LOCAL_PLANNER)
        rest = {name: value for name, value in section.values.items() if name not in TOP_SPEEDS}
        _plain(rules, Section(section.name, rest, section.prefix), into)
        for name in TOP_SPEEDS:
            if name in section.values:
                _top_speed(own, section.prefix + name, section.values[name], into)

    def _global_planner(self, section: Section, into: "Translation") -> None:
        """Translate the parameters of a global planner; global_planner/GlobalPlanner is one of two plug-ins."""
        if section.name == "NavfnROS":
            _plain(NAVFN, section, into)
            return
        place = "parameters.dijkstra."
        rules = {
            name: ParameterRule(rule.to.replace(place, f"parameters.{self._global}."), rule.text, rule.convert)
            for name, rule in GLOBAL_PLANNER.items()
        }
        rules["use_dijkstra"] = ParameterRule(text=f"global_planner/GlobalPlanner becomes {self._global}")
        _plain(rules, section, into)

    def _recovery(self, section: Section, into: "Translation") -> None:
        kind = self._behaviors[section.name]
        rules = rules_of_recovery(kind)
        none = "has no such parameters" if kind in RECOVERIES else "is not known"
        for name, given in section.values.items():
            part = section.prefix + name
            if rules is None:
                into[1].without_effect(part, f"the recovery behaviour {kind} {none}", given.line)
            elif name not in rules:
                refuse_unknown(part, name, rules, given.line, into[1])
            else:
                rule = rules[name]
                to = f"parameters.{section.name}.{rule.to}" if rule.to else ""
                apply_once(ParameterRule(to, rule.text, rule.convert), part, given, into)


def _local_planners(values: Mapping[str, GivenValue]) -> list[str]:
    """Return the names of the local planner that drives: of move_base, and of move_base_flex."""
    of_flex = [kind for _, kind in plugins_of(values["controllers"].value)][:1] if "controllers" in values else []
    return ([str(values[LOCAL_PLANNER].value)] if LOCAL_PLANNER in values else []) + of_flex


def _behaviors(sections: list[Section]) -> dict[str, str]:
    """Return the types of the recovery behaviours by their names."""
    for section in reversed(sections):
        given = section.values.get("recovery_behaviors")
        if not section.name and given is not None and isinstance(given.value, list):
            return {name: RECOVERIES.own_name(kind) for name, kind in plugins_of(given.value)}
    return {each.name: each.type for each in (CONSERVATIVE, ROTATE, AGGRESSIVE)}


def _layers(sections: list[Section]) -> dict[str, str]:
    """Return the types of the layers that costmaps list, by their names."""
    lists = [given.value for section in sections for name, given in section.values.items() if name == "plugins"]
    listed = [each for found in lists if isinstance(found, list) for each in found if isinstance(each, dict)]
    return {str(each["name"]): str(each["type"]) for each in listed if {"name", "type"} <= each.keys()}


def _apply(rules: ParameterRules, given: Mapping[str, GivenValue], section: Section, into: "Translation") -> None:
    """Apply the rules of a program to its parameters; names that another program reads have no effect."""
    own = {}
    for name, value in given.items():
        if name in rules or not _is_read_elsewhere(section.prefix + name, name, value, into[1]):
            own[name] = value
    apply_known(rules, own, section.node, into)


def _is_read_elsewhere(part: str, name: str, given: GivenValue, report: ImportReport) -> bool:
    readers = readers_of(name)
    if readers:
        report.without_effect(part, f"a parameter of {readers}, which does not read it here", given.line)
    return bool(readers)


def _plain(rules: ParameterRules, section: Section, into: "Translation") -> None:
    """Apply rules to a section, in which a name may have further ones below it."""
    own = {}
    for name, given in section.values.items():
        above = name.partition(".")[0]
        if name not in rules and above in rules and not rules[above].to:
            into[1].without_effect(section.prefix + name, rules[above].text, given.line)
        else:
            own[name] = given
    _apply(rules, own, section, into)


def _top_speed(own: str, part: str, given: GivenValue, into: "Translation") -> None:
    """Lower the top speed of a planner to one of all directions, where 0 is none."""
    draft, report = into
    place = f"parameters.{own}.max_vel_x"
    forward = draft.get("parameters", {}).get(own, {}).get("max_vel_x")
    try:
        speed = number(given.value)
    except InvalidParameter as error:
        report.refused(part, str(error), given.line)
        return
    if speed == 0.0 or (isinstance(forward, int | float) and forward <= speed):
        report.without_effect(part, "max_vel_x is the top speed, and no higher", given.line)
    else:
        report.withdraw(place, ImportOutcome.NO_EFFECT, f"{part} is lower, and bounds it")
        put(draft, place, speed)
        report.translated(part, f"{place} = {speed!r}", given.line, to=place)


def _costmap(rules: ParameterRules, section: Section, into: "Translation") -> None:
    """Apply the rules of a costmap to its section, or to one of a layer."""
    for name, given in section.values.items():
        reason = _idle(name, section.values)
        if reason and rules.get(layer_rule_name(name, rules), _NONE).to:
            into[1].without_effect(section.prefix + name, reason, given.line)
        else:
            _costmap_value(rules, section.prefix + name, given, into)


def _idle(name: str, values: Mapping[str, GivenValue]) -> str:
    """Return why a layer or a source of observations has no effect; empty if it has, or there is none."""
    above, _, last = name.rpartition(".")
    of_layer = f"{name.partition('.')[0]}.enabled" if above else "enabled"
    enabled, kind = values.get(of_layer), values.get(f"{above}.data_type" if above else "data_type")
    if enabled is not None and enabled.value is False:
        return "its layer is off; obstacles are inflated as the robot file says"
    if last in RANGES and kind is not None and kind.value != "LaserScan":
        return f"the range is that of the laser, and not of a {kind.value}"
    return ""


def _costmap_value(rules: ParameterRules, part: str, given: GivenValue, into: "Translation") -> None:
    """Apply the rule of a costmap to a value, which may be one of a layer or of a source of observations."""
    report = into[1]
    short = layer_rule_name(part, rules)
    rule = rules.get(short)
    if rule is None:
        if not _is_read_elsewhere(part, short, given, report):
            refuse_unknown(part, short, rules, given.line, report)
    elif not rule.to:
        report.without_effect(part, rule.text, given.line)
    elif not is_left_open(part, given, report):
        apply_once(rule, part, given, into)
        if rules is COMMON_RULES and short in BOTH:
            apply_once(LOCAL_RULES[short], part, given, into)


def _drop_radius(translations: "list[Translation]") -> None:
    """Leave out the radius of a robot that has a footprint, too, as costmap_2d does."""
    costmaps = [draft.get("parameters", {}).get("global_costmap", {}) for draft, _ in translations]
    if any("footprint" in costmap for costmap in costmaps):
        for costmap, (_, report) in zip(costmaps, translations, strict=True):
            if costmap.pop("robot_radius", None) is not None:
                place = "parameters.global_costmap.robot_radius"
                report.withdraw(place, ImportOutcome.NO_EFFECT, "footprint is given, too, and wins")
