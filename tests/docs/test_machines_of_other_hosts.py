"""Commands of machines.md for other hosts are valid; tests/e2e/test_two_machines.py shows that they work."""

import re
import shlex
from types import ModuleType

import pytest

from endpoints.cli import machine_join, machine_ticket, up
from engine.agent.master_session import LEASE
from engine.processes.heartbeats import BEAT_PERIOD, MISSED
from robots.cli.command_parser import CommandParser
from tests.support.documents import blocks, text_of

PAGE = "docs/machines.md"
LINES = [shlex.split(line) for block in blocks(PAGE, "bash") for line in block.splitlines()]
COMMANDS: dict[tuple[str, ...], ModuleType] = {
    ("ppaas", "up"): up,
    ("ppaas", "machine", "ticket"): machine_ticket,
    ("ppaas", "machine", "join"): machine_join,
}


@pytest.mark.parametrize("words", LINES, ids=" ".join)
def test_the_command_lines_are_valid(words: list[str]) -> None:
    (begin,) = [begin for begin in COMMANDS if tuple(words[: len(begin)]) == begin]
    parser = CommandParser(exit_on_error=False)
    COMMANDS[begin].configure(parser)
    parser.parse_args(words[len(begin) :])


def test_each_command_is_shown() -> None:
    assert {begin for begin in COMMANDS for words in LINES if tuple(words[: len(begin)]) == begin} == set(COMMANDS)


def test_the_numbers_are_those_of_the_code() -> None:
    parser = CommandParser()
    machine_ticket.configure(parser)
    minutes = parser.parse_args([]).valid / 60
    assert f"good for {minutes:.0f} minutes" in re.sub(r"\s+", " ", text_of(PAGE))
    links = re.sub(r"\s+", " ", text_of("docs/architecture.md"))
    assert f"not answered for {LEASE:.0f} s" in links
    assert f"after {MISSED * BEAT_PERIOD:.0f} s at the earliest" in links
