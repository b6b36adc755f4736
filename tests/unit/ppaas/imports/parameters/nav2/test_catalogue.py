"""All names that Nav2 documents are known, and the rules lead to places that a robot file has."""

import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from ppaas.controllers.registry import CONTROLLERS
from ppaas.imports.parameters.nav2.catalogue import BY_NAME, NODES, rule_of
from ppaas.imports.parameters.nav2.importer import import_nav2
from ppaas.imports.parameters.nav2.servers import CONTROLLER
from ppaas.imports.parameters.nav2.tables import PluginTable
from ppaas.imports.parameters.rules import ParameterRule
from ppaas.imports.report import ImportOutcome
from ppaas.planners.registry import PLANNERS
from ppaas.plugins import PluginRegistry
from ppaas.recoveries.registry import RECOVERIES

DOCUMENTED: list[dict[str, Any]] = tomllib.loads(
    Path(__file__).with_name("documented.toml").read_text(encoding="utf-8")
)["source"]


def listed(source: dict[str, Any]) -> str:
    return f"{source['node']} {source.get('plugin', '')} {source['from'].split()[1]}"


def file_with(source: dict[str, Any]) -> tuple[str, set[str]]:
    """Return a file that has all names of a source, each with a value, and the parts of its report."""
    node, plugin = source["node"], source.get("plugin")
    group = next((g for g in BY_NAME[node].groups if plugin and g.table_of(plugin) is not None), None)
    lines: dict[str, str] = {}
    if group is not None:
        lines |= {group.lists[0]: "[Mine]", "Mine.plugin": plugin}
    prefix = "Mine." if group is not None else ""
    for kind, names in source.items():
        below = {"names": "", "of_sources": "lidar."}.get(kind, f"{kind.removeprefix('of_')}_part.")
        if kind != "names" and not kind.startswith("of_"):
            continue
        if kind.startswith("of_") and kind != "of_sources":
            lines[kind.removeprefix("of_")] = f"[{below[:-1]}]"
        for name in names.split():
            lines.setdefault(f"{prefix}{below}{name}", "1.0")
    if f"{prefix}observation_sources" in lines and prefix:
        lines[f"{prefix}observation_sources"] = "lidar"
    text = f"{node}:\n  ros__parameters:\n" + "".join(f"    {name}: {value}\n" for name, value in lines.items())
    return text, {f"{node}.{name}" for name in lines}


@pytest.mark.parametrize("source", DOCUMENTED, ids=listed)
def test_all_documented_names_are_known(source: dict[str, Any]) -> None:
    text, parts = file_with(source)
    _, report = import_nav2(text.encode(), "nav2.yaml")
    unknown = [entry.part for entry in report.entries if entry.text.startswith("unknown parameter")]
    assert unknown == []
    assert parts <= {entry.part for entry in report.entries}
    idle = [e.part for e in report.of(ImportOutcome.NO_EFFECT) if "no list of the node names" in e.text]
    assert idle == []


def tables() -> Iterator[PluginTable]:
    for node in NODES:
        for group in node.groups:
            yield from group.tables


def rules() -> Iterator[ParameterRule]:
    for node in NODES:
        yield from node.rules.values()
    for table in tables():
        yield from table.rules.values()
        yield from table.sources.values()


def test_every_rule_has_a_place_or_a_reason() -> None:
    assert all(rule.to or rule.text for rule in rules())


@pytest.mark.parametrize("registry", [CONTROLLERS, PLANNERS, RECOVERIES])
def test_plug_ins_become_the_ones_that_their_aliases_name(registry: PluginRegistry[Any]) -> None:
    ours = {table.plugin: table.becomes for table in tables() if table.becomes in registry}
    assert ours
    old = {plugin for plugin in ours if plugin.startswith("nav2_recoveries")}  # before Humble
    assert {plugin: registry.own_name(plugin) for plugin in ours.keys() - old} == {
        plugin: own for plugin, own in ours.items() if plugin not in old
    }


def test_rules_of_nodes_are_for_one_controller_place() -> None:
    places = {rule.to.split(".")[1] for rule in rules() if rule.to.startswith("parameters.")}
    assert CONTROLLER in places
    assert rule_of(BY_NAME["recoveries_server"], "use_sim_time") is not None
