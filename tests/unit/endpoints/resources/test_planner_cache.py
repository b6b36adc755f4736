"""Disk cache of the planner catalogue."""

import os
import sys
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from endpoints.resources import installed_planners


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "straight_lines"
    folder.mkdir()
    (folder / "__init__.py").write_text("raise ImportError('nobody is to import this')")
    (folder / "planner.py").write_text("class Straight: ...")
    monkeypatch.syspath_prepend(tmp_path)
    entry = EntryPoint("straight", "straight_lines.planner:Straight", installed_planners.GROUP)
    monkeypatch.setattr(
        installed_planners, "entry_points", lambda group: [entry] if group == installed_planners.GROUP else []
    )
    return folder


def test_cache_file_depends_on_planner_files_and_question(package: Path) -> None:
    before = installed_planners.cache_file("?")
    assert installed_planners.cache_file("?") == before
    assert installed_planners.cache_file("!") != before
    os.utime(package / "planner.py", ns=(1, 1))
    changed = installed_planners.cache_file("?")
    assert changed != before
    (package / "another.py").touch()
    assert installed_planners.cache_file("?") not in (before, changed)
    assert "straight_lines" not in sys.modules


def test_cache_file_accepts_a_planner_of_a_missing_package(package: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    entry = EntryPoint("gone", "no_such_package_at_all:Gone", installed_planners.GROUP)
    before = installed_planners.cache_file("?")
    monkeypatch.setattr(installed_planners, "entry_points", lambda group: [entry])
    assert installed_planners.cache_file("?") != before
