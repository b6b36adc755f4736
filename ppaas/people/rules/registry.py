"""Registry of rules by name."""

from ppaas.people.rules.base import PeopleRule
from ppaas.plugins import PluginRegistry

RULES: PluginRegistry[PeopleRule] = PluginRegistry(
    "ppaas.people_rules",
    "rule",
    PeopleRule,  # type: ignore[type-abstract]
    aliases={},
)


def create(name: str) -> PeopleRule:
    """Return a new rule by its name.

    Raises
    ------
    NotFound
        No rule of that name is installed; the text lists the installed ones.
    NotPermitted
        It is installed, but no administrator has allowed it.
    """
    return RULES.create(name, {})


def rule_names() -> tuple[str, ...]:
    """Return the names of all installed rules."""
    return RULES.names()
