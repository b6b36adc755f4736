"""Page of the parameters of Nav2: what becomes of each of them, from the tables that translate them."""

from collections.abc import Iterator

from docs.site.reference.import_rules import rule_table
from docs.site.reference.markdown import code
from docs.site.reference.markdown import page as joined
from ppaas.imports.parameters.known_names import OF_ANY_NODE
from ppaas.imports.parameters.nav2.catalogue import NODES
from ppaas.imports.parameters.nav2.pursuit import SHIM
from ppaas.imports.parameters.nav2.tables import NodeTable, PluginTable

INTRODUCTION = """
What `ppaas robot put --nav2` ([I come from Nav2](../from-nav2.md)) does with each parameter of Nav2, by node and
plug-in, from Humble to Rolling. A place in the robot file means that it is taken or translated; names without effect
are in one row for each reason. Limits and tolerances go to the local planner of the robot, `LOCAL_PLANNER`.
"""


def page() -> str:
    """Return the page."""
    parts = [part for node in NODES for part in _node(node)]
    return joined("# Parameters of Nav2", INTRODUCTION, *parts, "## All nodes", rule_table(OF_ANY_NODE))


def _node(node: NodeTable) -> Iterator[str]:
    yield f"## {code(node.node)}"
    if node.also:
        yield "Also named " + ", ".join(map(code, node.also)) + "."
    yield rule_table(node.rules)
    shown: list[str] = []
    for group in node.groups:
        if group.untyped is not None:
            yield f"Sections that {code(group.lists[0])} names:"
            yield rule_table(group.untyped.rules)
        for plugin in group.tables:
            if plugin.plugin not in shown:
                shown.append(plugin.plugin)
                yield from _plugin(plugin)


def _plugin(plugin: PluginTable) -> Iterator[str]:
    becomes = f", which becomes {code(plugin.becomes)}" if plugin.becomes else ""
    if plugin is SHIM:
        becomes = ", which becomes its primary controller"
    yield f"### {code(plugin.plugin)}{becomes}"
    yield rule_table(plugin.rules) or "It has no parameters."
    if plugin.sources:
        yield "Each of its observation sources:"
        yield rule_table(plugin.sources)
