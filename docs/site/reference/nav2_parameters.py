"""Page of the parameters of Nav2: what becomes of each of them, from the tables that translate them."""

from collections.abc import Iterator

from docs.site.reference.markdown import code, table
from docs.site.reference.markdown import page as joined
from ppaas.imports.parameters.nav2.catalogue import NODES
from ppaas.imports.parameters.nav2.other_nodes import GENERAL
from ppaas.imports.parameters.nav2.pursuit import SHIM
from ppaas.imports.parameters.nav2.servers import CONTROLLER
from ppaas.imports.parameters.nav2.tables import NodeTable, PluginTable
from ppaas.imports.parameters.rules import ParameterRule, ParameterRules

INTRODUCTION = """
What `ppaas robot put --nav2` ([I come from Nav2](../from-nav2.md)) does with each parameter of Nav2, by node and
plug-in, from Humble to Rolling. A place in the robot file means that it is taken or translated; names without effect
are in one row for each reason. Limits and tolerances go to the local planner of the robot, `LOCAL_PLANNER`.
"""

COLUMNS = ("parameter", "outcome", "becomes, or why not")

OF_CONTROLLER = f"parameters.{CONTROLLER}."


def page() -> str:
    """Return the page."""
    parts = [part for node in NODES for part in _node(node)]
    return joined("# Parameters of Nav2", INTRODUCTION, *parts, "## All nodes", _table(GENERAL))


def _node(node: NodeTable) -> Iterator[str]:
    yield f"## {code(node.node)}"
    if node.also:
        yield "Also named " + ", ".join(map(code, node.also)) + "."
    yield _table(node.rules)
    shown: list[str] = []
    for group in node.groups:
        if group.untyped is not None:
            yield f"Sections that {code(group.lists[0])} names:"
            yield _table(group.untyped.rules)
        for plugin in group.tables:
            if plugin.plugin not in shown:
                shown.append(plugin.plugin)
                yield from _plugin(plugin)


def _plugin(plugin: PluginTable) -> Iterator[str]:
    becomes = f", which becomes {code(plugin.becomes)}" if plugin.becomes else ""
    if plugin is SHIM:
        becomes = ", which becomes its primary controller"
    yield f"### {code(plugin.plugin)}{becomes}"
    yield _table(plugin.rules) or "It has no parameters."
    if plugin.sources:
        yield "Each of its observation sources:"
        yield _table(plugin.sources)


def _table(rules: ParameterRules) -> str:
    rows = [_row(name, rule) for name, rule in rules.items() if rule.to]
    reasons: dict[str, list[str]] = {}
    for name, rule in rules.items():
        if not rule.to:
            reasons.setdefault(rule.text, []).append(name)
    rows += [(", ".join(map(code, names)), "no effect", reason) for reason, names in reasons.items()]
    return table(COLUMNS, rows)


def _row(name: str, rule: ParameterRule) -> tuple[str, str, str]:
    place = rule.to.replace(OF_CONTROLLER, "parameters.LOCAL_PLANNER.")
    same = name.rpartition(".")[2] == rule.to.rpartition(".")[2] and not rule.text
    words = code(place) + (f": {rule.text}" if rule.text else "")
    return code(name), "taken" if same else "translated", words
