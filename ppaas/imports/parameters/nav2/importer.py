"""Import of a parameter file of Nav2: Humble, Iron, Jazzy, Kilted, Lyrical and Rolling, and those before them."""

import sys
from collections.abc import Iterable, Mapping

from ppaas.errors import InvalidParameter
from ppaas.imports.parameters.draft import Draft
from ppaas.imports.parameters.known_names import refuse_unknown, report_repeated
from ppaas.imports.parameters.nav2.catalogue import BY_NAME, FOREIGN, INNER, NODES, SMOOTHED, owner_of, rule_of
from ppaas.imports.parameters.nav2.earlier_releases import as_today, with_plugins
from ppaas.imports.parameters.nav2.limits import START, add_start, fit_limits, smoothed
from ppaas.imports.parameters.nav2.nodes import WILDCARDS, NamedNode, Values, chosen_namespace, named, spread
from ppaas.imports.parameters.nav2.recoveries import add_recoveries
from ppaas.imports.parameters.nav2.sections import PRIMARY, PluginSection, known_in, rule_in, section_of, sections_of
from ppaas.imports.parameters.nav2.tables import NodeTable, known_names
from ppaas.imports.parameters.nav2.writer import SURE, DraftWriter, Parts
from ppaas.imports.parameters.ros_yaml import ROS2_KEY, GivenValue, read_parameter_file
from ppaas.imports.parameters.values import is_substitution, names_of
from ppaas.imports.report import ImportReport


def import_nav2(
    content: bytes, name: str, *, tree: bytes | None = None, namespace: str = ""
) -> tuple[Draft, ImportReport]:
    """Translate a parameter file of Nav2 into a draft of a robot file.

    Parameters
    ----------
    content : bytes
        The YAML file.
    name : str
        Its name, for the report.
    tree : bytes, optional
        XML of the behaviour tree that the robot navigates by; by default Nav2's own one.
    namespace : str
        Namespace of the robot, in a file for several; by default the first one.

    Raises
    ------
    InvalidParameter
        The file is no YAML of ROS 2, or the tree is no XML.
    """
    file = read_parameter_file(content)
    if not file.is_ros2:
        raise InvalidParameter(f"{name} has no {ROS2_KEY}, which each node has in parameter files of ROS 2")
    report = ImportReport(name)
    importer = _Importer(DraftWriter(report))
    report_repeated(file, report)
    importer.add_nodes({named(path): values for path, values in file.nodes.items()}, namespace)
    importer.finish(tree)
    return importer.writer.draft, report


def import_node(node: str, path: str, values: Values, report: ImportReport) -> Draft:
    """Translate the parameters of one node of Nav2 into a draft of a robot file, whatever its name in the file.

    Parameters
    ----------
    node : str
        Name of the node in Nav2.
    path : str
        Its name in the file.
    values : dict
    report : ImportReport
    """
    importer = _Importer(DraftWriter(report))
    importer.add_node(BY_NAME[node], named(path).path, values)
    importer.finish(None)
    return importer.writer.draft


class _Importer:
    def __init__(self, writer: DraftWriter) -> None:
        self.writer = writer
        self._report = writer.report
        self._behaviors: list[PluginSection] | None = None
        self._smoother: Parts = {}
        self._start: Parts = {}

    # -- nodes ---------------------------------------------------------------------------------------------------------

    def add_nodes(self, nodes: dict[NamedNode, Values], namespace: str) -> None:
        """Add all nodes: wildcards first, since a node's own parameters win; then in the order of the tables."""
        chosen = chosen_namespace(nodes, namespace)
        of_robot = [node for node in nodes if node.namespace in ("", chosen) or node.name not in BY_NAME]
        for node in nodes:
            if node not in of_robot:
                self._of_other_robot(node, chosen)
        for node in of_robot:
            if node.name in WILDCARDS:
                self._add_wildcard(node, nodes[node])
        today = {node: as_today(node.name, nodes[node]) for node in of_robot}
        for table in NODES:
            for node, given in today.items():
                if BY_NAME.get(given.node) is table:
                    self.add_node(table, node.path, given.values, given.shown)
        for node, given in today.items():
            if node.name not in WILDCARDS and given.node not in BY_NAME:
                self._add_unknown(node)

    def _of_other_robot(self, node: NamedNode, chosen: str) -> None:
        of = f"the namespace {chosen!r}" if chosen else "the robot without a namespace"
        self._report.without_effect(
            node.path, f"of another robot than {of}: --namespace {node.namespace} imports that one"
        )

    def _add_wildcard(self, node: NamedNode, values: Values) -> None:
        by_node, unknown = spread(values)
        for table in NODES:
            if table.node in by_node:
                self.add_node(table, node.path, by_node[table.node])
        names = [known for table in NODES for known in known_names(table)]
        for name in unknown:
            near = self._report.nearest_name(name, names, SURE)
            if near:
                text = f"unknown parameter; did you mean {near!r}?"
                self._report.refused(f"{node.path}.{name}", text, values[name].line)
            else:
                self._report.without_effect(f"{node.path}.{name}", "no node of Nav2 has it", values[name].line)

    def _add_unknown(self, node: NamedNode) -> None:
        near = self._report.nearest_name(node.name, BY_NAME, SURE)
        if node.name.endswith(INNER):
            self._report.without_effect(node.path, "a node within another one, which the clone does not have")
        elif node.name in FOREIGN:
            self._report.without_effect(node.path, FOREIGN[node.name])
        elif near and near != node.name:
            self._report.refused(node.path, f"unknown node: did you mean {near}?")
        else:
            self._report.without_effect(node.path, "no node of Nav2 that is known")

    # -- parameters of a node ------------------------------------------------------------------------------------------

    def add_node(self, table: NodeTable, path: str, given_values: Values, shown: Mapping[str, str] = {}) -> None:
        """Add the parameters of a node; ``shown`` has the names in the file of those that are renamed."""
        values = with_plugins(given_values)
        sections = sections_of(table, values)
        lists = {key for group in table.groups for key in group.lists}
        if table.node == "behavior_server":
            self._behaviors = list(sections.values())
        if table.node == "controller_server":
            self._choose_controller(sections.values())
        for name, given in values.items():
            part = f"{path}.{shown.get(name, name)}".rstrip(".")
            section = section_of(name, sections)
            if given.value is None or given.value == {}:
                self._report.without_effect(part, "has no value", given.line)
            elif name in lists and not is_substitution(given.value):
                listed = ", ".join(names_of(given.value)) or "none"
                self._report.taken(part, f"names the sections {listed}", given.line)
            elif section is not None:
                self._add_in(section, part, name[len(section.name) + 1 :], given)
            elif table.node == "velocity_smoother" and name in SMOOTHED:
                self._smoother[name] = (part, given)
            elif table.node == "amcl" and name in START:
                self._start[name] = (part, given)
            else:
                self._add_parameter(table, part, name, given, values)

    def _choose_controller(self, sections: Iterable[PluginSection]) -> None:
        for section in sections:
            if section.counts and section.table is not None and section.table.becomes:
                self.writer.controller = section.table.becomes

    def _add_parameter(self, table: NodeTable, part: str, name: str, given: GivenValue, values: Values) -> None:
        rule = rule_of(table, name)
        first = name.partition(".")[0]
        defaults = {each for group in table.groups for each in group.defaults}
        if rule is not None:
            if not self._has_no_speeds(table, values, part, name, given):
                self.writer.apply(rule, part, given)
        elif "." in name and (f"{first}.plugin" in values or first in defaults):
            self._report.without_effect(part, f"no list of the node names the section {first}", given.line)
        elif owner := owner_of(table, name):
            self._report.without_effect(part, f"a parameter of {owner}, which does not read it here", given.line)
        else:
            refuse_unknown(part, name, [*known_names(table), *defaults], given.line, self._report)

    def _has_no_speeds(self, table: NodeTable, values: Values, part: str, name: str, given: GivenValue) -> bool:
        """Report a parameter of a server of filter infos whose filter has no speeds."""
        if table.node != "costmap_filter_info_server" or name not in ("type", "base", "multiplier"):
            return False
        kind = values.get("type")
        if kind is not None and kind.value in (1, 2):
            return False
        self._report.without_effect(part, "a filter of this type has no speeds", given.line)
        return True

    # -- parameters of a plug-in ---------------------------------------------------------------------------------------

    def _add_in(self, section: PluginSection, part: str, name: str, given: GivenValue) -> None:
        if not section.counts:
            self._report.without_effect(part, f"one plug-in of the list counts: {section.chosen}", given.line)
        elif name in ("plugin", PRIMARY, f"{PRIMARY}.plugin") and section.group.untyped is None:
            self.writer.plugin(section, part, name, given)
        elif section.table is None:
            plugin = section.plugin or "a plug-in that the file does not name"
            self._report.without_effect(part, f"of {plugin}, which is not known", given.line)
        else:
            rule = rule_in(section, name)
            if rule is None:
                refuse_unknown(part, name, known_in(section), given.line, self._report)
            else:
                self.writer.apply(rule, part, given)

    # -- what depends on several parameters ----------------------------------------------------------------------------

    def finish(self, tree: bytes | None) -> None:
        """Add what depends on several parameters: limits, recoveries, the start."""
        smoothed(self.writer, self._smoother)
        fit_limits(self.writer)
        plugins = None if self._behaviors is None else [each.plugin for each in self._behaviors]
        add_recoveries(self.writer, plugins, tree)
        add_start(self.writer, self._start)
        self._report.entries.sort(key=lambda entry: entry.line or sys.maxsize)
