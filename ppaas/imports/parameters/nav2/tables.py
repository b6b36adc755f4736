"""Form of the tables: parameters of a node or of a plug-in, with what becomes of each."""

from collections.abc import Iterable, Mapping

import msgspec

from ppaas.imports.parameters.rules import Convert, ParameterRule, ParameterRules, without_effect

Given = str | tuple[str, Convert] | tuple[str, Convert, str]
"""Place in the robot file, relative to the node or plug-in of the table, with conversion and text."""


class PluginTable(msgspec.Struct, frozen=True):
    """Parameters of one kind of plug-in, relative to its name in the file.

    Parameters
    ----------
    plugin : str
        Nav2's name of the plug-in: ``dwb_core::DWBLocalPlanner``.
    rules : mapping
        By the names of the parameters.
    becomes : str
        Name of our plug-in, if it has one.
    sources : mapping
        Rules of each of its observation sources, relative to the source's name.
    """

    plugin: str
    rules: ParameterRules
    becomes: str = ""
    sources: ParameterRules = {}


class PluginGroup(msgspec.Struct, frozen=True):
    """List parameter of a node that names sections, each the parameters of a plug-in.

    Parameters
    ----------
    lists : tuple of str
        Names of the parameter in the releases: ``progress_checker_plugin``, ``progress_checker_plugins``.
    tables : tuple of PluginTable
    defaults : mapping of str to str
        Plug-ins by section, if the file has no list.
    only_first : bool
        Whether only the first plug-in has an effect.
    untyped : PluginTable, optional
        Table of sections that have no plug-in, such as zones and docks.
    """

    lists: tuple[str, ...]
    tables: tuple[PluginTable, ...] = ()
    defaults: Mapping[str, str] = {}
    only_first: bool = False
    untyped: PluginTable | None = None

    def table_of(self, plugin: str) -> PluginTable | None:
        """Return the table of a plug-in, in either spelling: ``pkg::Name``, ``pkg/Name``."""
        wanted = spelled(plugin)
        return next((table for table in self.tables if table.plugin == wanted), None)


class NodeTable(msgspec.Struct, frozen=True):
    """Parameters of one node.

    Parameters
    ----------
    node : str
        Name in Nav2's own files: ``controller_server``.
    rules : mapping
    groups : tuple of PluginGroup
    also : tuple of str
        Other names of the same node: ``recoveries_server`` for ``behavior_server``.
    """

    node: str
    rules: ParameterRules
    groups: tuple[PluginGroup, ...] = ()
    also: tuple[str, ...] = ()


def spelled(plugin: str) -> str:
    """Return the name of a plug-in with ``::`` after its package."""
    return plugin.strip().replace("/", "::")


def rules_of(
    node: str,
    same: str = "",
    converted: Mapping[str, Given] | None = None,
    no_effect: Mapping[str, str] | None = None,
    convert: Mapping[str, Convert] | None = None,
) -> dict[str, ParameterRule]:
    """Return the rules of a table.

    Parameters
    ----------
    node : str
        Node or plug-in of the robot file under ``parameters``.
    same : str
        Names that are the same in the robot file, separated by spaces.
    converted : mapping, optional
        Place by name; a place with a dot is one in ``parameters``, one with ``:`` before it a field of the file.
    no_effect : mapping, optional
        Names without effect, separated by spaces, by the reason.
    convert : mapping, optional
        Conversions of ``same`` names; they do not change values, but refuse invalid ones and read them as ROS does.
    """
    rules: dict[str, ParameterRule] = {}
    for name in same.split():
        rules[name] = ParameterRule(f"parameters.{node}.{name}", "", (convert or {}).get(name))
    for name, given in (converted or {}).items():
        to, conversion, words = (*((given,) if isinstance(given, str) else given), None, None)[:3]
        rules[name] = ParameterRule(_place(node, str(to)), str(words or ""), conversion)
    for reason, names in (no_effect or {}).items():
        rules |= without_effect(reason, names)
    return rules


def known_names(table: NodeTable) -> Iterable[str]:
    """Return all names that a node knows at its top level, with its lists of plug-ins."""
    yield from table.rules
    for group in table.groups:
        yield from group.lists


def _place(node: str, to: str) -> str:
    if to.startswith(":"):
        return to[1:]
    return f"parameters.{to}" if "." in to else f"parameters.{node}.{to}"
