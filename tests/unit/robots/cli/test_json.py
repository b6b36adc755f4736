"""Option ``--json`` of all commands and verbs: programs read every result, so that they need not read tables."""

import argparse

import pytest

from tests.support.commands import leaves

WITHOUT = {
    "ppaas bench": "each bench has the option, once it is named",
    "ppaas bridge agv": "runs until it is ended, and prints a log",
    "ppaas bridge free-fleet": "runs until it is ended, and prints a log",
    "ppaas bridge mavlink": "runs until it is ended, and prints a log",
    "ppaas bridge rmf": "runs until it is ended, and prints a log",
    "ppaas bridge ros1": "runs until it is ended, and prints a log",
    "ppaas bridge ros2": "runs until it is ended, and prints a log",
    "ppaas bridge vda5050": "runs until it is ended, and prints a log",
    "ppaas completion": "prints a script for a shell",
    "ppaas machine join": "runs until it is ended, and prints a log",
    "ppaas mcp": "speaks a protocol on standard output",
    "ppaas simulate": "runs until it is ended, and prints a log",
    "ppaas task schema": "prints JSON in any case",
    "ppaas up": "runs until it is ended, and prints a log",
}
"""Commands without the option, and why."""

COMMANDS = {leaf.prog: leaf for leaf in leaves()}


def takes_json(parser: argparse.ArgumentParser) -> bool:
    """Return whether a command has the option ``--json``."""
    return any("--json" in action.option_strings for action in parser._actions)


@pytest.mark.parametrize("command", sorted(COMMANDS.keys() - WITHOUT.keys()))
def test_a_command_with_a_result_prints_it_as_json_if_asked(command: str) -> None:
    assert takes_json(COMMANDS[command])


@pytest.mark.parametrize("command", sorted(WITHOUT))
def test_a_command_without_the_option_exists_and_lacks_it(command: str) -> None:
    assert not takes_json(COMMANDS[command])
