"""Commands of upgrading.md are valid, its numbers are those of the code, and its refusal is the one of the code."""

import re
import shlex
from types import ModuleType

import pytest

from endpoints.cli import machine_hand_over, warm
from endpoints.cloud_processes.leading import SUCCESSION
from engine.protocols.versions import Protocols, agree
from ppaas.errors import Conflict
from robots.cli.command_parser import CommandParser
from robots.cli.commands import machine
from tests.support.documents import blocks, text_of

PAGE = "docs/upgrading.md"
LINES = [shlex.split(line) for block in blocks(PAGE, "bash") for line in block.splitlines()]
INLINE = [shlex.split(text) for text in re.findall(r"`(ppaas machine [a-z]+ [^`]+)`", text_of(PAGE))]
COMMANDS: dict[tuple[str, ...], ModuleType] = {
    ("ppaas", "machine", "hand-over"): machine_hand_over, ("ppaas", "warm"): warm, ("ppaas", "machine"): machine,
}  # fmt: skip


@pytest.mark.parametrize("words", [*LINES, *INLINE], ids=" ".join)
def test_the_command_lines_are_valid(words: list[str]) -> None:
    begin = next(begin for begin in COMMANDS if tuple(words[: len(begin)]) == begin)
    parser = CommandParser(exit_on_error=False)
    COMMANDS[begin].configure(parser)
    parser.parse_args(words[len(begin) :])


def test_the_refusal_is_the_one_of_the_code(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.protocols.versions.__version__", "0.3.0")
    with pytest.raises(Conflict) as refused:
        agree("machine 'hall-2'", "0.5.0", Protocols(4, 5), Protocols(2, 3))
    assert [block.strip() for block in blocks(PAGE, "text")] == [f"conflict: {refused.value}"]


def test_the_numbers_are_those_of_the_code() -> None:
    assert f"1 if no standby leads after {SUCCESSION:g} s" in re.sub(r"\s+", " ", text_of(PAGE))
