"""Recoveries of a robot: those of its behaviour tree, or of Nav2's own one, as far as the file has them."""

from msgspec.structs import replace

from ppaas.imports.parameters.nav2.behavior_tree import CLEAR, Tree, as_behaviors, default_tree, read_tree
from ppaas.imports.parameters.nav2.servers import BEHAVIORS
from ppaas.imports.parameters.nav2.writer import DraftWriter

LIST = "parameters.move_base.recovery_behaviors"
RATE = "parameters.move_base.planner_frequency"

OF_SERVER = {"rotate_recovery": "spin", "back_up": "backup"}
"""Names of recoveries that the parameters of the behavior server are for, by their type."""


def add_recoveries(writer: DraftWriter, plugins: list[str] | None, content: bytes | None) -> None:
    """Add the recoveries and the rate of planning to a draft.

    Parameters
    ----------
    writer : DraftWriter
    plugins : list of str, optional
        Plug-ins of the behavior server, by their Nav2 names; None if the file has no such server.
    content : bytes, optional
        The robot's own tree.

    Raises
    ------
    InvalidParameter
        The tree is no tree.
    """
    if content is not None:
        _add_tree(writer, read_tree(content))
    elif plugins is not None:
        tree = default_tree()
        ours = {table.plugin: table.becomes for table in BEHAVIORS}
        kinds = {ours.get(plugin, "") for plugin in plugins} | {CLEAR[1]}
        tree = replace(tree, recoveries=tuple(each for each in tree.recoveries if each.type in kinds))
        _add_list(writer, tree, "behavior_server", "the recoveries of Nav2's own tree")
    tables = writer.draft.get("parameters", {})
    names = {each["name"]: each["type"] for each in tables.get("move_base", {}).get("recovery_behaviors", ())}
    for name in OF_SERVER.values():
        if name not in names:
            for parameter in list(tables.get(name, {})):
                writer.drop(f"parameters.{name}.{parameter}", f"no recovery of the robot is {name}")
            tables.pop(name, None)
    for name, kind in names.items():
        of_server = OF_SERVER.get(kind, name)
        if name != of_server and of_server in tables:
            tables[name] = tables[of_server] | tables[name]


def _add_tree(writer: DraftWriter, tree: Tree) -> None:
    writer.translate(RATE, tree.rate, "bt_xml.RateController", "the rate of planning while the robot drives [Hz]")
    _add_list(writer, tree, "bt_xml.RecoveryNode", "the recoveries of the tree, once for each retry")
    for name in tree.others:
        writer.report.without_effect(f"bt_xml.{name}", "the clone drives by its own state machine")


def _add_list(writer: DraftWriter, tree: Tree, part: str, text: str) -> None:
    writer.translate(LIST, as_behaviors(tree.recoveries), part, text)
    for each in dict.fromkeys((one.name, tuple(one.parameters.items())) for one in tree.recoveries):
        name, parameters = each
        for parameter, value in parameters:
            writer.translate(f"parameters.{name}.{parameter}", value, f"{part}.{name}", "as the tree gives it")
