"""Commands of standby.md are valid, and its numbers are those of the code; tests/faults/test_standby.py drives one."""

import re
import shlex
from types import ModuleType

import pytest

from endpoints.cli import machine_ticket, up
from engine.agent.master_session import LEASE
from engine.control.master_driver import RETURN_TIMEOUT
from engine.leadership.leadership import TIMING
from robots.cli.command_parser import CommandParser
from robots.cli.commands import machine
from tests.support.documents import blocks, text_of

PAGE = "docs/standby.md"
TEXT = re.sub(r"\s+", " ", text_of(PAGE))
INLINE: list[str] = re.findall(r"`(ppaas [^`]+)`", TEXT)
LINES = [shlex.split(line) for block in blocks(PAGE, "bash") for line in block.splitlines()]
COMMANDS: dict[tuple[str, ...], ModuleType] = {("ppaas", "up"): up, ("ppaas", "machine", "ticket"): machine_ticket}


@pytest.mark.parametrize("words", [*LINES, *(shlex.split(text) for text in INLINE if " up " in text)], ids=" ".join)
def test_the_command_lines_are_valid(words: list[str]) -> None:
    (begin,) = [begin for begin in COMMANDS if tuple(words[: len(begin)]) == begin]
    parser = CommandParser(exit_on_error=False)
    COMMANDS[begin].configure(parser)
    parser.parse_args(words[len(begin) :])


def test_the_limit_of_the_own_machine_is_a_command() -> None:
    (text,) = [text for text in INLINE if " machine limit " in text]
    parser = CommandParser(exit_on_error=False)
    machine.configure(parser)
    assert parser.parse_args(shlex.split(text)[2:]).max_containers == 0


def test_the_numbers_are_those_of_the_code() -> None:
    assert f"in the store every {TIMING.renew:g} s. A standby looks at it every {TIMING.look:g} s" in TEXT
    assert f"has not changed for {TIMING.patience:g} s" in TEXT
    assert f"last renewal was asked for {TIMING.validity:g} s ago" in TEXT
    assert f"answered its heartbeats for {LEASE:g} s" in TEXT
    assert f"starts these robots {RETURN_TIMEOUT:g} s after it took over" in TEXT
