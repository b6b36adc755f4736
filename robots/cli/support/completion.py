"""Command ``ppaas completion SHELL``: prints the script by which a shell completes commands, verbs and options."""

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path

NAME = "completion"
HELP = 'print the script by which a shell completes commands: eval "$(ppaas completion bash)"'

SHELLS = ("bash", "zsh", "tcsh")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("shell", choices=SHELLS, help="the shell that loads the script")


def run(arguments: argparse.Namespace) -> int:
    """Print the script."""
    import shtab  # noqa: PLC0415 - ``ppaas --help`` loads this module

    from robots.cli.main import parser_of  # noqa: PLC0415 - which loads this module

    parser = parser_of([])
    for action in _actions(parser):
        if action.type is Path:
            vars(action)["complete"] = shtab.FILE
    sys.stdout.write(shtab.complete(parser, shell=arguments.shell) + "\n")
    return 0


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    """Yield the arguments of a parser, of its commands and of their verbs."""
    for action in parser._actions:
        yield action
        if isinstance(action, argparse._SubParsersAction):
            for verb in action.choices.values():
                yield from _actions(verb)
