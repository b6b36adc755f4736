"""Commands of machines.md work, and its settings are those of the code."""

import re
import shlex
from pathlib import Path
from types import ModuleType

import pytest

from endpoints.cli import machine_join, machine_ticket, up
from endpoints.rest.cluster.schemas import MachineChange
from engine.agent.host_load import AT_A_TIME, PERIOD
from engine.agent.master_session import LEASE
from engine.control.master_driver import LEAVE_GRACE
from engine.master.master import MOVES
from engine.processes.heartbeats import BEAT_PERIOD, MISSED
from engine.specs.cores import MEMORY_PER_CORE
from engine.specs.machine_settings import MOST_LABELS, MachineSettings
from robots.cli.command_parser import CommandParser
from tests.support.cloud.cloud import RunningCloud
from tests.support.documents import blocks, run_shell, script, table, text_of

PAGE = "docs/machines.md"


def test_the_commands_work(cloud: RunningCloud, tmp_path: Path) -> None:
    printed = run_shell(script(PAGE) + "\nppaas machine label local zone=", tmp_path, cloud)
    assert '"labels": {"zone": "hall-2"}' in printed and '"max_containers": 40' in printed


def test_the_settings_are_those_of_the_code() -> None:
    rows = table(PAGE, "setting", "default", "what it is")
    assert {name for name, _, _ in rows} == set(MachineChange.model_fields) == set(MachineSettings.__struct_fields__)
    defaults = {name: default for name, default, _ in rows if default}
    assert defaults == {name: str(getattr(MachineSettings(), name)).lower() for name in defaults}


def test_the_numbers_are_those_of_the_code() -> None:
    text = re.sub(r"\s+", " ", text_of(PAGE))
    assert f"counts for {MEMORY_PER_CORE >> 20} MiB with each core" in text
    assert f"up to {MOST_LABELS} of" in text
    assert MOVES == 4 and "up to four at a time" in text
    assert f"has not ended after {LEAVE_GRACE:.0f} s" in text
    assert f"every {PERIOD:.0f} s each machine pings up to {AT_A_TIME} others" in text
    assert MISSED * BEAT_PERIOD == 4.0 and "for four seconds" in text


HOSTS_PAGE = "docs/machines.md"
LINES = [shlex.split(line) for block in blocks(HOSTS_PAGE, "bash") for line in block.splitlines()]
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


def test_the_numbers_of_other_hosts_are_those_of_the_code() -> None:
    parser = CommandParser()
    machine_ticket.configure(parser)
    minutes = parser.parse_args([]).valid / 60
    assert f"good for {minutes:.0f} minutes" in re.sub(r"\s+", " ", text_of(HOSTS_PAGE))
    links = re.sub(r"\s+", " ", text_of("docs/architecture.md"))
    assert f"not answered for {LEASE:.0f} s" in links
    assert f"after {MISSED * BEAT_PERIOD:.0f} s at the earliest" in links
