"""Parameters of a node of another program: the ones that its rules know, and all others."""

import re
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING

from ppaas.imports.parameters.ros_yaml import ROS2_KEY, GivenValue, ParameterFile
from ppaas.imports.parameters.rules import ParameterRule, ParameterRules, apply_rule, without_effect
from ppaas.imports.parameters.values import is_substitution
from ppaas.imports.report import ImportReport

if TYPE_CHECKING:
    from ppaas.imports.parameters.draft import Translation

OF_ANY_NODE: ParameterRules = {
    **without_effect("the cloud takes the time of the messages", "use_sim_time"),
    **without_effect(
        "clients of the cloud have no quality of service", "qos_overrides", "allow_parameter_qos_overrides"
    ),
    **without_effect(
        "the cloud starts and watches its nodes, and has services and threads of another kind",
        "autostart autostart_node bond_timeout bond_heartbeat_period attempt_respawn_reconnection lifecycle_node "
        "introspection_mode service_introspection_mode action_server_result_timeout start_type_description_service "
        "enable_stamped_cmd_vel use_realtime_priority use_composition use_intra_process_comms diagnostic_updater",
    ),
}
"""Parameters that every node of ROS has, or that manage its life."""

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)[eE][+-]?\d+")


def rule_of_any_node(name: str) -> ParameterRule | None:
    """Return the rule of a parameter that every node has, or of the section that it is in; None for others."""
    return OF_ANY_NODE.get(name) or OF_ANY_NODE.get(name.partition(".")[0])


def refuse_unknown(part: str, name: str, known: Iterable[str], line: int, report: ImportReport) -> None:
    """Report a parameter that no rule knows, with the known name that is most like its name."""
    names = list(known)
    below = sorted(each[len(name) + 1 :] for each in names if each.startswith(f"{name}."))
    if below:
        report.refused(part, f"it must be a section, with {', '.join(below)}", line)
        return
    near = report.nearest_name(name, names)
    hint = f"did you mean {near!r}?" if near else "look it up in the tables of parameters, and leave it out"
    report.refused(part, f"unknown parameter; {hint}", line)


def as_ros_reads(given: GivenValue) -> GivenValue:
    """Return a value as ROS reads it: a number without a point, such as ``1e-3``, is text in YAML."""
    if isinstance(given.value, str) and _NUMBER.fullmatch(given.value):
        return GivenValue(float(given.value), given.line)
    return given


def apply_once(rule: ParameterRule, part: str, given: GivenValue, into: "Translation") -> None:
    """Apply a rule to a parameter; others that the same place of the robot file had its value from lose, and say so."""
    draft, report = into
    apply_rule(rule, part, as_ros_reads(given), draft, report)
    report.replaces_earlier(f"{part} sets {rule.to}, too, and wins")


def is_left_open(part: str, given: GivenValue, report: ImportReport) -> bool:
    """Return whether a value is left open, and report that: it is null, or has a substitution of a launch file."""
    if given.value is None:
        report.refused(part, "it has no value; write one, or remove the line", given.line)
        return True
    if is_substitution(str(given.value)):
        report.refused(part, f"{given.value!r} is filled in by a launch file: write the value itself", given.line)
        return True
    return False


def apply_known(rules: ParameterRules, given: Mapping[str, GivenValue], node: str, into: "Translation") -> None:
    """Apply the rules of a node to its parameters; unknown names are reported with the nearest known one.

    Parameters
    ----------
    rules : mapping
        Rules by the names of the node's parameters; `OF_ANY_NODE` hold, too.
    given : mapping
    node : str
        Name of the node in the report; empty for parameters outside any node.
    into : Translation
        It is changed.
    """
    report = into[1]
    known = {**OF_ANY_NODE, **rules}
    for name, value in given.items():
        part = f"{node}.{name}" if node else name
        rule = rules.get(name) or rule_of_any_node(name)
        if rule is None:
            refuse_unknown(part, name, known, value.line, report)
        elif not rule.to or not is_left_open(part, value, report):
            apply_once(rule, part, value, into)


def report_repeated(file: ParameterFile, report: ImportReport) -> None:
    """Report the names that occur twice in one mapping of a file."""
    for path, line in file.repeated:
        part = ".".join(each for each in path.split(".") if each != ROS2_KEY)
        report.without_effect(part, "given before, too: that value has no effect, this one counts", line)


def values_of_node(
    file: ParameterFile, is_wanted: Callable[[str], bool], report: ImportReport
) -> tuple[str, dict[str, GivenValue]]:
    """Return the name and the parameters of one node of a file.

    Parameters for all nodes (``/**``) hold, too, unless the node has its own value. If no node has a wanted name and
    there is one only, that one is meant: its user has renamed it.

    Parameters
    ----------
    file : ParameterFile
    is_wanted : callable
        Returns whether the last part of a node's name, in lower case, may be the program's.
    report : ImportReport
        It takes names that occur twice in one mapping, and nodes that are not wanted.
    """
    report_repeated(file, report)
    general = [name for name in file.nodes if not name.strip("/*")]
    named = [name for name in file.nodes if name not in general]
    wanted = [name for name in named if is_wanted(name.rpartition("/")[2].lower())]
    if not wanted and len(named) == 1 and not general:
        wanted = named
    values: dict[str, GivenValue] = {}
    for name in (*general, *wanted):
        _report_overridden(name, values.keys() & file.nodes[name].keys(), values, report)
        values |= file.nodes[name]
    for name in named:
        if name not in wanted:
            report.without_effect(name, "these are the parameters of another node", _first_line(file.nodes[name]))
    return (wanted or general or [""])[-1], values


def _report_overridden(
    later: str, names: Iterable[str], values: Mapping[str, GivenValue], report: ImportReport
) -> None:
    for name in sorted(names):
        report.without_effect(name, f"{later or 'a line outside any node'} sets it, too, and wins", values[name].line)


def _first_line(values: Mapping[str, GivenValue]) -> int:
    return min((value.line for value in values.values()), default=0)
