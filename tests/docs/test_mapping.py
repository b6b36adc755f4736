"""The page about mapping: what it says about trajectories and logs of CARMEN is what the code does."""

import re
import shlex
from pathlib import Path

import pytest

from ppaas.mapping.trajectories import LINES, TRAJECTORY_FORMATS, format_trajectory
from robots.cli.main import main
from robots.recordings.carmen import FIELDS, laser_of
from tests.support.documents import blocks, table
from tests.support.world.log_text import carmen_log
from tests.support.world.ring_drive import ring_drive

PAGE = "docs/mapping.md"
SCANS = 30


def test_the_formats_of_trajectories_are_those_of_the_code() -> None:
    rows = table(PAGE, "format", "a line", "where")
    assert [name.lower() for name, *_ in rows] == list(TRAJECTORY_FORMATS)
    for (_, line, _), words in zip(rows[:2], LINES.values(), strict=False):
        assert words.startswith(line.strip("`"))


def test_the_commands_about_trajectories_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    [block] = [block for block in blocks(PAGE, "sh") if "--score truth.tum" in block]
    drive = ring_drive()
    (tmp_path / "drive.clf").write_text(carmen_log(drive.first(SCANS)))
    (tmp_path / "truth.tum").write_text(format_trajectory(drive.log.stamps[:SCANS], drive.true[:SCANS], "tum"))
    monkeypatch.chdir(tmp_path)
    for line in block.splitlines():
        assert main(shlex.split(line)[1:]) == 0
    assert "rmse_m" in capsys.readouterr().out


def test_the_messages_of_carmen_are_those_that_are_read() -> None:
    rows = table(PAGE, "message", "what is read")
    scans = [name for row in rows[:2] for name in re.findall(r"`(\w+)`", row[0])]
    assert len(scans) == 8
    assert all(laser_of(name) for name in scans)
    [row] = [told for name, told in rows if "laser_front_laser_resolution" in name]
    assert set(FIELDS) <= set(map(int, re.findall(r"\d+", row)))
