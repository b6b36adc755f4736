"""``ppaas bench backup`` on small stores: all steps, with kills, and what it makes of commands to robots."""

import json
from pathlib import Path

import pytest
from rich.progress import Progress

from benchmarks.stores import backup, backup_robots
from benchmarks.stores.backup_robots import CommandGaps, DrivenBackups
from robots.cli.main import main

QUIET, BACKED_UP = CommandGaps(20.0, 3000, 50.0, 61.0, 80.0), CommandGaps(20.1, 3001, 50.0, 63.0, 99.0)


def test_backups_and_restorations_are_measured_and_killed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    driven: list[tuple[bool, int, int]] = []

    async def drive(folder: Path, robots: int, turns: int, progress: Progress) -> DrivenBackups:
        driven.append(((folder / "data" / "ppaas.sqlite").exists(), robots, turns))
        return DrivenBackups(robots, turns, QUIET, BACKED_UP)

    monkeypatch.setattr(backup, "SIDE", 64)
    monkeypatch.setattr(backup_robots, "drive", drive)
    typed = ["--plans", "100", "--maps", "1", "--kills", "1", "--robots", "2", "--turns", "4"]
    assert main(["bench", "backup", *typed, "--folder", str(tmp_path), "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert [*result["seconds"]] == [
        "tar", "backup", "backup again", "check", "restore and compare", "backup, killed 1 times",
        "restore and compare, killed 1 times",
    ]  # fmt: skip
    assert result["robots"]["backed_up"]["p99"] == 63.0
    assert driven == [(True, 2, 4)]
    assert not [*tmp_path.iterdir()]
