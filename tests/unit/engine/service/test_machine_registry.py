"""Tests of the machine registry, as the next cloud process reads it."""

import logging
from pathlib import Path

import pytest

from engine.service.machine_registry import MachineRegistry


def test_it_has_those_that_were_noted_last_and_nobody_after_an_end_in_order(tmp_path: Path) -> None:
    roll = MachineRegistry(tmp_path / "here.json")
    assert roll.left() == []
    roll.note(["m2", "local"])
    assert MachineRegistry(tmp_path / "here.json").left() == ["local", "m2"]
    roll.note([])
    assert roll.left() == [] and list(tmp_path.iterdir()) == []


def test_what_cannot_be_read_or_kept_is_nobody(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    (tmp_path / "here.json").write_text('{"m1": 1}')
    assert MachineRegistry(tmp_path / "here.json").left() == []
    caplog.set_level(logging.WARNING)
    MachineRegistry(tmp_path / "here.json" / "below").note(["m1"])
    assert "could not store the names of machines" in caplog.text
