"""Tests of the machine registry, as the next cloud process reads it."""

import logging
from pathlib import Path

import pytest

from engine.service.administration import MachineRegistry


def test_registry_has_the_last_noted_machines(tmp_path: Path) -> None:
    registry = MachineRegistry(tmp_path / "here.json")
    assert registry.left() == []
    registry.note(["m2", "local"])
    assert MachineRegistry(tmp_path / "here.json").left() == ["local", "m2"]
    registry.note([])
    assert registry.left() == [] and list(tmp_path.iterdir()) == []


def test_unreadable_registry_is_empty_and_unwritable_one_is_logged(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "here.json").write_text('{"m1": 1}')
    assert MachineRegistry(tmp_path / "here.json").left() == []
    caplog.set_level(logging.WARNING)
    MachineRegistry(tmp_path / "here.json" / "below").note(["m1"])
    assert "could not store the names of machines" in caplog.text
