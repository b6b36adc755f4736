"""Names of nodes in a file: namespaces, wildcards, costmaps within a namespace of their name."""

from collections.abc import Iterable, Mapping

import msgspec

from ppaas.imports.parameters.nav2.catalogue import BY_NAME, NODES, rule_of
from ppaas.imports.parameters.nav2.tables import NodeTable
from ppaas.imports.parameters.ros_yaml import GivenValue

WILDCARDS = frozenset({"*", "**"})

Values = dict[str, GivenValue]


class NamedNode(msgspec.Struct, frozen=True):
    """Node of a file.

    Parameters
    ----------
    path : str
        As in the file: ``robot1/local_costmap/local_costmap``.
    namespace : str
        Its namespace, without wildcards: ``robot1``.
    name : str
        ``local_costmap``; a wildcard for parameters of all nodes.
    """

    path: str
    namespace: str
    name: str


def named(path: str) -> NamedNode:
    """Return a node by its path in a file."""
    parts = [part for part in path.split("/") if part]
    *above, name = parts or [""]
    if above and above[-1] == name:
        above.pop()
    shown = f"/{path}" if path[:1] in WILDCARDS else path
    return NamedNode(shown, "/".join(part for part in above if part not in WILDCARDS), name)


def chosen_namespace(nodes: Iterable[NamedNode], wanted: str) -> str:
    """Return the namespace of the robot that is imported: the wanted one, or the first one that has a node of Nav2."""
    if wanted:
        return wanted.strip("/")
    known = [node.namespace for node in nodes if node.name in BY_NAME]
    return "" if "" in known or not known else known[0]


def spread(values: Values) -> tuple[dict[str, Values], list[str]]:
    """Return the parameters of a wildcard by the node that takes each, and the names that no node knows.

    A parameter goes to the first node in whose table it has an effect, or else to the first one that knows it, since
    most names without effect mean the same everywhere.
    """
    spread_: dict[str, Values] = {}
    unknown: list[str] = []
    lists = {key: table for table in NODES for group in table.groups for key in group.lists}
    for name, given in values.items():
        table = _taker(name, lists, values)
        if table is None:
            unknown.append(name)
        else:
            spread_.setdefault(table.node, {})[name] = given
    return spread_, unknown


def _taker(name: str, lists: Mapping[str, NodeTable], values: Values) -> NodeTable | None:
    if name in lists:
        return lists[name]
    knowing = [(table, rule) for table in NODES if (rule := rule_of(table, name)) is not None]
    if knowing:
        return next((table for table, rule in knowing if rule.to), knowing[0][0])
    first = name.partition(".")[0]
    listing = (key for key, given in values.items() if key in lists and first in _listed(given))
    return next((lists[key] for key in listing), None)


def _listed(given: GivenValue) -> list[object]:
    return given.value if isinstance(given.value, list) else [given.value]
