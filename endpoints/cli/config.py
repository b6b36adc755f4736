"""``ppaas config``: check, show, explain and reload the settings of ``ppaas up`` and ``ppaas machine join``."""

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from endpoints.cli.settings_tree import TABLES
from endpoints.settings.effective import SettingsTree, raise_if_any
from endpoints.settings.names import did_you_mean
from endpoints.settings.setting import Setting, settings_of
from ppaas.distribution import BASE, check_versions
from ppaas.errors import InvalidInput

NAME = "config"
HELP = "check, show, explain and reload the settings of 'ppaas up' and 'ppaas machine join'"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = (
        "Settings come from options, from variables PPAAS_..., from a file of TOML, and from defaults, the first of "
        "these that gives one. Passwords are never shown."
    )
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    check = verbs.add_parser("check", help="check a file of settings and the variables; report all that is wrong")
    show = verbs.add_parser("show", help="show the settings that a command would take, each with its source")
    explain = verbs.add_parser("explain", help="explain a setting: meaning, type, option, variable, key, reload")
    for verb in (check, show):
        verb.add_argument(
            "file",
            nargs="?",
            type=Path,
            metavar="FILE",
            help="file of settings (PPAAS_CONFIG, else /etc/ppaas/ppaas.toml if it exists)",
        )
    show.add_argument("--table", choices=list(TABLES), help="only the settings of this table (both)")
    reloading = verbs.add_parser(
        "reload", help="have a cloud read its settings again, without a restart; run it on the host of the cloud"
    )
    reloading.add_argument("--data", type=Path, default=Path("var"), help="data folder of the cloud (./%(default)s)")
    explain.add_argument("key", metavar="KEY", help="key, as up.port, or its name alone, as port")
    for verb in (check, show, explain, reloading):
        verb.add_argument("--json", action="store_true", help="print JSON")


def run(arguments: argparse.Namespace) -> int:
    """Execute the verb; return 0 unless a checked setting is wrong."""
    check_versions(BASE, "cloud")
    if arguments.verb == "explain":
        return _explain(arguments)
    if arguments.verb == "check":
        return _check(arguments)
    if arguments.verb == "reload":
        return _reload(arguments)
    return _show(arguments)


def _check(arguments: argparse.Namespace) -> int:
    try:
        tree = SettingsTree(TABLES, arguments.file)
    except InvalidInput as error:
        problems, where = [str(error)], None
    else:
        where = None if tree.file is None else str(tree.file.path)
        problems = tree.misspelt() + [problem for table in TABLES for problem in tree.values(table)[1]]
        problems = list(dict.fromkeys(problems))
    if arguments.json:
        sys.stdout.write(json.dumps({"good": not problems, "file": where, "problems": problems}) + "\n")
    else:
        good = [f"no problems in {'the variables; there is no file' if where is None else where}"]
        sys.stdout.writelines(f"{line}\n" for line in problems or good)
    return 1 if problems else 0


def _show(arguments: argparse.Namespace) -> int:
    tree = SettingsTree(TABLES, arguments.file)
    rows: list[dict[str, Any]] = []
    problems = tree.misspelt()
    for table in [arguments.table] if arguments.table else TABLES:
        values, wrong = tree.values(table)
        problems += wrong
        rows += [
            {"key": setting.key, "value": setting.shown(each.value), "source": each.source}
            for setting, each in values.items()
        ]
    raise_if_any(problems)
    if arguments.json:
        sys.stdout.write(json.dumps(rows) + "\n")
        return 0
    cells = [(row["key"], _text(row["value"]), row["source"]) for row in rows]
    widths = [max(len(row[column]) for row in cells) for column in (0, 1)]
    sys.stdout.writelines(
        f"{key.ljust(widths[0])}  {value.ljust(widths[1])}  {source}\n" for key, value, source in cells
    )
    return 0


def _explain(arguments: argparse.Namespace) -> int:
    settings = settings_of(TABLES)
    key = arguments.key.removeprefix("--")
    found = [setting for setting in settings if key in (setting.key, setting.name)]
    if not found:
        known = {name for setting in settings for name in (setting.key, setting.name)}
        raise InvalidInput(f"{arguments.key!r} is no setting{did_you_mean(key, known)}")
    facts = [_facts(setting) for setting in found]
    if arguments.json:
        sys.stdout.write(json.dumps(facts) + "\n")
    else:
        blocks = ["".join(f"{name.ljust(9)} {_text(value)}\n" for name, value in each.items()) for each in facts]
        sys.stdout.write("\n".join(blocks))
    return 0


def _reload(arguments: argparse.Namespace) -> int:
    from endpoints.cli.reload import reload  # noqa: PLC0415 - ``ppaas --help`` loads this module

    report = reload(arguments.data)
    if arguments.json:
        changed = [{name: getattr(one, name) for name in one.__struct_fields__} for one in report.changed]
        sys.stdout.write(json.dumps({"file": report.file, "changed": changed}) + "\n")
        return 0
    for one in report.changed:
        state = "applied" if one.applied else "needs a restart"
        sys.stdout.write(f"{one.key}: {one.before} -> {one.after} ({state})\n")
    if not report.changed:
        where = "the variables; there is no file" if report.file is None else report.file
        sys.stdout.write(f"nothing has changed in {where}\n")
    return 0


def _facts(setting: Setting) -> dict[str, Any]:
    return {
        "key": setting.key,
        "meaning": setting.help,
        "type": setting.type_name,
        "default": setting.shown(setting.action.default),
        "option": setting.flag,
        "variable": setting.variable,
        "reload": setting.reloads,
    }


def _text(value: Any) -> str:
    """Return a value as a file of settings has it; - for none."""
    if value is None:
        return "-"
    return value if isinstance(value, str) and value else json.dumps(value, ensure_ascii=False)
