"""Parameters of the nodes of a set-up while they are collected, with the report of what became of each."""

from collections.abc import Collection, Mapping
from typing import Any

import yaml

from ppaas.exports.ros2.releases import ABSENT, Release
from ppaas.exports.ros2.robot import RobotToExport
from ppaas.imports.parameters.ros_yaml import ROS2_KEY, GivenValue
from ppaas.imports.parameters.rules import ParameterRule, ParameterRules, apply_rule, put
from ppaas.imports.report import ImportReport

ELSEWHERE = ("the outline in both costmaps", "track_unknown_space of both costmaps")
"""In place of the places of parameters that another part of a set-up has."""

COSTMAPS = ("local_costmap", "global_costmap")
"""Nodes that are in a namespace of their name."""


class SetupDraft:
    """Draft of the parameter files.

    Parameters
    ----------
    robot : RobotToExport
    release : Release

    Attributes
    ----------
    report : ImportReport
        What became of each parameter of the clone.
    """

    def __init__(self, robot: RobotToExport, release: Release) -> None:
        self.robot = robot
        self.release = release
        self.report = ImportReport(robot.name)
        self._nodes: dict[str, Any] = {}

    def put(self, place: str, value: Any) -> None:
        """Set the parameter at a dotted place, which begins with its node, unless the release has no such parameter."""
        if not self._is_absent(place):
            put(self._nodes, place, value)

    def section(
        self,
        name: str,
        rules: ParameterRules,
        values: Mapping[str, Any] | None = None,
        *,
        tuned: Collection[str] = (),
        why: str = "",
    ) -> None:
        """Translate all parameters of a node or plug-in of the clone; those without a value have no effect in it.

        Parameters
        ----------
        name : str
        rules : ParameterRules
            What becomes of each.
        values : mapping, optional
            Their values; by default those that the clone has in use.
        tuned : collection of str
            Parameters whose defaults are tuned for the clone's algorithm: they are translated if the robot file sets
            them, and otherwise the program has its own default.
        why : str
            Why those have another default.
        """
        for parameter, value in (self.robot.in_use.get(name, {}) if values is None else values).items():
            part, rule = f"{name}.{parameter}", rules[parameter]
            if value is None:
                continue
            if rule.to in ELSEWHERE:
                self.report.translated(part, rule.to)
            elif parameter in tuned and not self.robot.is_given(name, parameter):
                self.report.without_effect(part, why)
            elif rule.to and self._is_absent(rule.to):
                self.report.without_effect(part, f"Nav2 of {self.release.value} has no {rule.to.partition('.')[2]}")
            else:
                apply_rule(rule, part, GivenValue(_plain(value), 0), self._nodes, self.report)

    def unused(self, name: str, why: str) -> None:
        """Report that no parameter of a node or plug-in has an effect; those with defaults are not listed."""
        for parameter in self.robot.in_use.get(name, {}):
            if self.robot.is_given(name, parameter):
                self.report.without_effect(f"{name}.{parameter}", why)

    def nodes(self) -> list[str]:
        """Return the names of the nodes that have parameters."""
        return list(self._nodes)

    def value(self, node: str, name: str) -> Any:
        """Return a parameter that was set; None if it was not."""
        found: Any = self._nodes.get(node, {})
        for step in name.split("."):
            found = found.get(step) if isinstance(found, Mapping) else None
        return found

    def yaml(self, *nodes: str) -> bytes:
        """Return the parameter file of some nodes."""
        document: dict[str, Any] = {}
        for node in nodes:
            table = {ROS2_KEY: self._nodes[node]}
            document[node] = {node: table} if node in COSTMAPS else table
        return yaml.safe_dump(document, sort_keys=False, default_flow_style=None, width=110).encode()

    def _is_absent(self, place: str) -> bool:
        return self.release in ABSENT.get(place.partition(".")[2], ())


def without_effect(why: str, *names: str) -> dict[str, ParameterRule]:
    """Return the rules of parameters that have no effect, for one reason."""
    return {name: ParameterRule(text=why) for name in names}


def same(node: str, *names: str) -> dict[str, ParameterRule]:
    """Return the rules of parameters that keep their names, at a dotted place."""
    return {name: ParameterRule(f"{node}.{name}") for name in names}


def renamed(node: str, text: str = "", **names: str) -> dict[str, ParameterRule]:
    """Return the rules of parameters that get other names, at a dotted place."""
    return {name: ParameterRule(f"{node}.{other}", text) for name, other in names.items()}


def _plain(value: Any) -> Any:
    """Return a value of JSON with lists in place of tuples, as YAML has them."""
    return [_plain(each) for each in value] if isinstance(value, list | tuple) else value
