"""``ppaas bench backup`` with commands that only note what was asked: its steps, its kills, and its result."""

import json
import subprocess
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from rich.progress import Progress

from benchmarks.stores import backup, backup_robots, routes
from benchmarks.stores.backup_robots import CommandGaps, DrivenBackups
from robots.cli.main import main
from storage.records import PlanRecord
from tests.support.storage.full_store import paths

QUIET, BACKED_UP = CommandGaps(20.0, 3000, 50.0, 61.0, 80.0), CommandGaps(20.1, 3001, 50.0, 63.0, 99.0)


class Drawn:
    """Plans of a fleet, without planning."""

    def records(self, first: int, count: int, *, smooth: bool) -> Iterator[PlanRecord]:
        return iter(paths(count))


class Commands:
    """Notes the commands of a bench; one that may be killed goes on until it is, and then ends with ``status``."""

    def __init__(self, status: int = 0) -> None:
        self.whole: list[str] = []
        self.killed: list[str] = []
        self._status = status

    def run(self, command: list[str], **_: Any) -> None:
        self.whole.append(" ".join(command[-9:] if command[0] == "tar" else command[3:5]))

    def begin(self, command: list[str], **_: Any) -> SimpleNamespace:
        def wait(timeout: float | None = None) -> int:
            if timeout is not None and not self._status:
                raise subprocess.TimeoutExpired(command, timeout)
            return self._status

        return SimpleNamespace(wait=wait, send_signal=lambda number: self.killed.append(f"{command[3]} {number}"))


def bench(monkeypatch: pytest.MonkeyPatch, folder: Path, commands: Commands, *options: str) -> int:
    monkeypatch.setattr(backup, "SIDE", 64)
    monkeypatch.setattr(routes, "routes", lambda *_: Drawn())
    monkeypatch.setattr(subprocess, "run", commands.run)
    monkeypatch.setattr(subprocess, "Popen", commands.begin)
    return main(["bench", "backup", "--plans", "100", "--maps", "1", "--folder", str(folder), "--json", *options])


def test_each_step_is_measured_and_robots_drive_at_last(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    driven: list[tuple[bool, int, int]] = []

    async def drive(folder: Path, robots: int, turns: int, progress: Progress) -> DrivenBackups:
        driven.append(((folder / "data" / "ppaas.sqlite").exists(), robots, turns))
        return DrivenBackups(robots, turns, QUIET, BACKED_UP)

    monkeypatch.setattr(backup_robots, "drive", drive)
    commands = Commands()
    monkeypatch.chdir(tmp_path)
    assert bench(monkeypatch, Path(), commands, "--kills", "2", "--robots", "2", "--turns", "4") == 0
    result = json.loads(capsys.readouterr().out)
    assert [*result["seconds"]] == [
        "tar", "backup", "backup again", "check", "restore and compare", "backup, killed 2 times",
        "restore and compare, killed 2 times",
    ]  # fmt: skip
    assert commands.killed == ["backup 9", "backup 9", "restore 9", "restore 9"]
    assert [command.split()[0] for command in commands.whole[1:]] == [
        "backup", "backup", "backup", "restore", "backup", "restore"
    ]  # fmt: skip
    assert result["robots"]["backed_up"]["p99"] == 63.0
    assert driven == [(True, 2, 4)]
    assert not [*tmp_path.iterdir()]


def test_an_error_of_a_command_that_had_been_killed_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert bench(monkeypatch, tmp_path, Commands(status=1), "--kills", "1", "--robots", "0") == 1
    assert "ppaas backup ended with status 1 after it had been killed" in capsys.readouterr().err
