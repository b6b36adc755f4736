"""Draft of a robot file while a file of Nav2 is read: each place has one value, and the report says whose."""

from typing import Any

from msgspec.structs import replace

from ppaas.imports.parameters.draft import Draft
from ppaas.imports.parameters.nav2.sections import PRIMARY, PluginSection
from ppaas.imports.parameters.nav2.servers import CONTROLLER
from ppaas.imports.parameters.ros_yaml import GivenValue
from ppaas.imports.parameters.rules import ParameterRule, apply_rule, put
from ppaas.imports.parameters.values import is_replaced
from ppaas.imports.report import ImportOutcome, ImportReport
from ppaas.navigation.parameters import MoveBaseParameters

Parts = dict[str, tuple[str, GivenValue]]
"""Parameters that are read together: part of the report and value, by name."""

SURE = 0.8
"""Likeness from which on an unknown node or plug-in is taken for a misspelt one, and not for one of another program."""

_OF_CONTROLLER = f"parameters.{CONTROLLER}."


class DraftWriter:
    """Writes values into a draft, and reports them.

    Parameters
    ----------
    report : ImportReport

    Attributes
    ----------
    draft : dict
    controller : str
        Local planner of the robot.
    """

    def __init__(self, report: ImportReport) -> None:
        self.report = report
        self.draft: Draft = {}
        self.controller = MoveBaseParameters().base_local_planner

    def of_controller(self) -> dict[str, Any]:
        """Return the parameters of the local planner in the draft."""
        found: dict[str, Any] = self.draft.get("parameters", {}).get(self.controller, {})
        return found

    def apply(self, rule: ParameterRule, part: str, given: GivenValue) -> None:
        """Apply a rule to a parameter; a value that was at its place before has no effect then."""
        if rule.to.startswith(_OF_CONTROLLER):
            rule = replace(rule, to=f"parameters.{self.controller}.{rule.to[len(_OF_CONTROLLER) :]}")
        if rule.to and is_replaced(given.value, rule.convert):
            reason = f"a launch file replaces {given.value!r}: give {rule.to} in the robot file"
            self.report.without_effect(part, reason, given.line)
            return
        apply_rule(rule, part, given, self.draft, self.report)
        self.report.replaces_earlier(f"{part} sets {rule.to}, and wins")

    def translate(self, place: str, value: Any, part: str, text: str, line: int = 0) -> None:
        """Put a value at a place of the draft, and report it."""
        put(self.draft, place, value)
        self.report.translated(part, f"{place} = {value!r}: {text}", line, to=place)
        self.report.replaces_earlier(f"{part} sets {place}, and wins")

    def drop(self, place: str, reason: str) -> None:
        """Leave a value out of the draft; the report says why."""
        *above, name = place.split(".")
        table: Any = self.draft
        for each in above:
            table = table.get(each, {})
        if name in table:
            del table[name]
            self.report.withdraw(place, ImportOutcome.NO_EFFECT, reason)

    # -- plug-ins ------------------------------------------------------------------------------------------------------

    def plugin(self, section: PluginSection, part: str, name: str, given: GivenValue) -> None:
        """Report the plug-in of a section, and choose it if it is a controller or planner."""
        table, lists = section.table, section.group.lists
        if name != "plugin":
            self.report.taken(part, f"see {section.name}.plugin", given.line)
        elif table is None:
            self._unknown(section, part, given)
        elif "controller_plugins" in lists:
            text = f"the primary controller of the shim, {table.plugin}" if section.shim else table.plugin
            self.translate("base_local_planner", table.becomes, part, text, given.line)
        elif "planner_plugins" in lists:
            self._planner(section, part, given)
        elif table.becomes:
            self.report.translated(part, f"the recovery behaviour {table.becomes}", given.line)
        elif any(rule.to for rule in (*table.rules.values(), *table.sources.values())):
            self.report.taken(part, "its parameters follow", given.line)
        else:
            reason = next((rule.text for rule in table.rules.values()), "it has no parameters")
            self.report.without_effect(part, reason, given.line)

    def _planner(self, section: PluginSection, part: str, given: GivenValue) -> None:
        assert section.table is not None
        own = section.table.becomes
        if section.name == section.chosen:
            self.translate("base_global_planner", own, part, section.table.plugin, given.line)
        else:
            self.report.translated(part, f"parameters of {own}, for requests that name it", given.line)

    def _unknown(self, section: PluginSection, part: str, given: GivenValue) -> None:
        if section.shim and not section.plugin:
            text = f"the shim needs a controller, {PRIMARY}; the robot has the default one"
            self.report.refused(part, text, given.line)
            return
        named = section.plugin or str(given.value)
        what = f"{PRIMARY} {named!r}" if section.shim else repr(named)
        names = [table.plugin for table in section.group.tables]
        near = self.report.nearest_name(named, names, SURE)
        hint = f"did you mean {near}?" if near else f"known: {', '.join(names)}"
        drives = "controller_plugins" in section.group.lists or "planner_plugins" in section.group.lists
        if near or drives:
            default = "; the robot has the default one" if drives else ""
            self.report.refused(part, f"unknown plug-in {what}: {hint}{default}", given.line)
        else:
            self.report.without_effect(part, f"unknown plug-in {what}: it is no part of Nav2", given.line)
