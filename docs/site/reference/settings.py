"""Page of the settings of ``ppaas up`` and ``ppaas machine join``, from their options."""

from docs.site.reference.markdown import code, table
from docs.site.reference.markdown import page as joined
from endpoints.cli.settings_tree import TABLES
from endpoints.settings.names import CONFIG_VARIABLE, OTHERS
from endpoints.settings.setting import Setting, settings_of

INTRODUCTION = """
All settings of `ppaas up` (table `[up]` of a file) and of `ppaas machine join` (table `[machine]`).
[Configuration](../configuration.md) describes files and variables. `ppaas config explain KEY` prints the same.
`ppaas config reload` applies new values of those with `yes` in the column `reload`; the others need a restart.
"""

COMMANDS = {"up": "ppaas up", "machine": "ppaas machine join"}
"""Commands of the tables."""


def page() -> str:
    """Return the page."""
    settings = settings_of(TABLES)
    parts = [part for name in TABLES for part in _section(name, [each for each in settings if each.table == name])]
    others = table(("variable", "read by"), [(code(name), words) for name, words in OTHERS.items()])
    return joined(
        "# Settings",
        INTRODUCTION,
        *parts,
        "## Other variables",
        f"{code(CONFIG_VARIABLE)} names the file of settings. These variables are no settings, and are not refused:",
        others,
    )


def _section(name: str, settings: list[Setting]) -> tuple[str, str]:
    columns = ("key", "type", "option", "variable", "reload", "meaning (default)")
    rows = [
        (
            code(each.name), each.type_name, code(each.flag), code(each.variable), "yes" if each.reloads else "",
            each.help,
        )
        for each in settings
    ]  # fmt: skip
    return f"## `[{name}]`: `{COMMANDS[name]}`", table(columns, rows)
