"""Sections of a node's parameters: which plug-in each belongs to, and the rule of each parameter in it."""

from collections.abc import Iterator, Mapping

import msgspec

from ppaas.imports.parameters.known_names import rule_of_any_node
from ppaas.imports.parameters.nav2.pursuit import OF_SHIM, SHIM
from ppaas.imports.parameters.nav2.tables import NodeTable, PluginGroup, PluginTable, spelled
from ppaas.imports.parameters.ros_yaml import GivenValue
from ppaas.imports.parameters.rules import ParameterRule
from ppaas.imports.parameters.values import names_of

PREFERRED = frozenset({"FollowPath", "follow_path", "GridBased", "grid_based", "general_goal_checker", "goal_checker"})
"""Sections that Nav2's behaviour trees name where they choose none; else the first one counts."""

PRIMARY = "primary_controller"

CLOUD = "depthimage_to_laserscan and octomap_server take what a camera sees"
"""Reason why ranges of clouds of points are not taken for ranges of the laser."""

Values = Mapping[str, GivenValue]


class PluginSection(msgspec.Struct, frozen=True):
    """Parameters of one plug-in in a file.

    Parameters
    ----------
    name : str
        Prefix of the parameters: ``FollowPath``.
    group : PluginGroup
    plugin : str
        Nav2's name of the plug-in, with ``::``; empty if the file does not say.
    table : PluginTable, optional
        None for an unknown plug-in.
    chosen : str
        Section of the group that counts, if only one does.
    shim : bool
        Whether a shim is around the plug-in, whose parameters are in the same section.
    parts : dict of str to str
        Names that the values of the section list, such as critics, with the parameter that lists them.
    clouds : set of str
        Names of its observation sources that are clouds of points.
    """

    name: str
    group: PluginGroup
    plugin: str
    table: PluginTable | None
    chosen: str
    shim: bool = False
    parts: dict[str, str] = msgspec.field(default_factory=dict)
    clouds: set[str] = msgspec.field(default_factory=set)

    @property
    def counts(self) -> bool:
        """Whether the plug-in has an effect at all."""
        return not self.group.only_first or self.name == self.chosen


def sections_of(table: NodeTable, values: Values) -> dict[str, PluginSection]:
    """Return the sections that the lists of a node name, by name."""
    found = {section.name: section for group in table.groups for section in _of_group(group, values)}
    for key, given in values.items():
        section = section_of(key, found)
        if section is not None and not key.endswith(".plugin"):
            name = key[len(section.name) + 1 :]
            if name.endswith(".data_type") and given.value == "PointCloud2":
                section.clouds.add(name.partition(".")[0])
            for part in names_of(given.value):
                section.parts.setdefault(part, name)
    return found


def _of_group(group: PluginGroup, values: Values) -> Iterator[PluginSection]:
    listed = [name for key in group.lists if key in values for name in names_of(values[key].value)]
    names = listed or [name for name in group.defaults if not any(key in values for key in group.lists)]
    chosen = next((name for name in names if name in PREFERRED), names[0] if names else "")
    for name in names:
        given = values.get(f"{name}.plugin")
        plugin = spelled(str(given.value)) if given is not None else group.defaults.get(name, "")
        if group.untyped is not None:
            yield PluginSection(name, group, plugin, group.untyped, chosen)
        elif plugin == SHIM.plugin:
            primary = _primary(name, values)
            yield PluginSection(name, group, primary, group.table_of(primary), chosen, shim=True)
        else:
            yield PluginSection(name, group, plugin, group.table_of(plugin), chosen)


def _primary(section: str, values: Values) -> str:
    """Return the plug-in within a shim; since Kilted it has a section of its own."""
    for key in (f"{section}.{PRIMARY}.plugin", f"{section}.{PRIMARY}"):
        if key in values:
            return spelled(str(values[key].value))
    return ""


def section_of(name: str, sections: Mapping[str, PluginSection]) -> PluginSection | None:
    """Return the section of a parameter: the one with the longest name."""
    parts = name.split(".")
    for count in range(len(parts) - 1, 0, -1):
        found = sections.get(".".join(parts[:count]))
        if found is not None:
            return found
    return None


def rule_in(section: PluginSection, name: str) -> ParameterRule | None:
    """Return the rule of a parameter of a section, by its name without that of the section; None if it is unknown."""
    table = section.table
    assert table is not None
    if section.shim:
        inner = name.removeprefix(f"{PRIMARY}.")
        if inner == name:
            own = OF_SHIM.get(table.becomes, {}).get(name) or SHIM.rules.get(name)
            if own is not None:
                return own
        name = inner
    return table.rules.get(name) or rule_of_any_node(name) or _below(section, table, name)


def _below(section: PluginSection, table: PluginTable, name: str) -> ParameterRule | None:
    """Return the rule of a parameter that stands under a name that the section gives: a source, a critic, a state."""
    first, _, rest = name.partition(".")
    if table.sources:
        found = table.sources.get(rest)
        return ParameterRule(text=CLOUD) if found is not None and found.to and first in section.clouds else found
    if any(known.startswith(f"{first}.") for known in table.rules):
        return None  # a known part, which has no such parameter
    naming = table.rules.get(section.parts.get(first, first))
    return ParameterRule(text=naming.text) if naming is not None and naming.text else None


def known_in(section: PluginSection) -> list[str]:
    """Return the names that a section knows, for the nearest one to an unknown name."""
    if section.table is None:
        return []
    names = [*section.table.rules, *section.table.sources]
    return names + list(SHIM.rules) if section.shim else names
