"""The settings of ``ppaas up`` and ``ppaas machine join``, from their options, variables and a file."""

import argparse
from collections.abc import Callable, Mapping

from endpoints.cli import machine_join, up
from endpoints.settings.effective import Origin, SettingsTree, raise_if_any
from endpoints.settings.setting import URLS

UP, MACHINE = "up", "machine"
"""Tables of the commands in a file."""

TABLES: Mapping[str, Callable[[argparse.ArgumentParser], None]] = {
    UP: up.configure,
    MACHINE: machine_join.configure,
}


def settled(
    table: str, arguments: argparse.Namespace, environment: Mapping[str, str] | None = None
) -> argparse.Namespace:
    """Return the arguments of a command with the settings of variables and the file that its words do not give.

    ``config`` of the result is the file that was read, or None. The URLs of stores stay in the environment, from which
    the command takes them.

    Parameters
    ----------
    table : str
    arguments : Namespace
        As the command line gives them.
    environment : mapping of str to str, optional
        Environment; by default the one that this process has now.

    Raises
    ------
    InvalidInput
        A setting is misspelt or wrong; the text has a line for each.
    """
    tree = SettingsTree(TABLES, arguments.config, environment)
    values, wrong = tree.values(table, _given(TABLES[table], arguments.words))
    raise_if_any(tree.misspelt() + wrong)
    taken = {
        setting.action.dest: each.value
        for setting, each in values.items()
        if not (each.origin == Origin.VARIABLE and setting.action.dest in URLS)
    }
    file = None if tree.file is None else tree.file.path
    return argparse.Namespace(**vars(arguments) | taken | {"config": file})


def _given(configure: Callable[[argparse.ArgumentParser], None], words: list[str]) -> dict[str, object]:
    """Return the values of the options that words give."""
    parser = argparse.ArgumentParser(add_help=False)
    configure(parser)
    for action in parser._actions:
        action.default = argparse.SUPPRESS
    return vars(parser.parse_args(words))
