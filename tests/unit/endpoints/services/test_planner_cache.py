"""What is told of planners, as it is kept between runs."""

import os
import sys
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from endpoints.services import installed_planners, planner_cache
from endpoints.services.installed_planners import InstalledPlanners
from ppaas.errors import Unavailable

TOLD = ("-c", """import sys; sys.stdout.write('[{"name": "straight"}]')""")


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr(installed_planners, "PROGRAM", TOLD)


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "straight_lines"
    folder.mkdir()
    (folder / "__init__.py").write_text("raise ImportError('nobody is to import this')")
    (folder / "planner.py").write_text("class Straight: ...")
    monkeypatch.syspath_prepend(tmp_path)
    entry = EntryPoint("straight", "straight_lines.planner:Straight", planner_cache.GROUP)
    monkeypatch.setattr(planner_cache, "entry_points", lambda group: [entry] if group == planner_cache.GROUP else [])
    return folder


async def test_planners_are_asked_once_for_all_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    first = await InstalledPlanners().all()
    assert first == [{"name": "straight"}]
    monkeypatch.setattr(sys, "executable", "/no/such/python")
    assert await InstalledPlanners().all() == first


async def test_what_is_kept_but_cannot_be_read_is_asked_anew(tmp_path: Path) -> None:
    await InstalledPlanners().all()
    [file] = (tmp_path / "cache").rglob("planners*")
    for broken in (b"", b"{}", b'[{"name": "str'):
        file.write_bytes(broken)
        assert await InstalledPlanners().all() == [{"name": "straight"}]


async def test_an_error_is_not_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(installed_planners, "PROGRAM", ("-c", "raise ImportError('not yet')"))
    with pytest.raises(Unavailable):
        await InstalledPlanners().all()
    assert list((tmp_path / "cache").rglob("planners*")) == []


async def test_where_nothing_can_be_kept_they_are_told_all_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "a file").touch()
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "a file" / "cache"))
    assert await InstalledPlanners().all() == [{"name": "straight"}]


def test_a_file_that_changes_another_planner_and_another_question_make_it_another(package: Path) -> None:
    before = planner_cache.cache_file("?")
    assert planner_cache.cache_file("?") == before
    assert planner_cache.cache_file("!") != before
    os.utime(package / "planner.py", ns=(1, 1))
    changed = planner_cache.cache_file("?")
    assert changed != before
    (package / "another.py").touch()
    assert planner_cache.cache_file("?") not in (before, changed)
    assert "straight_lines" not in sys.modules


def test_a_planner_whose_package_is_gone_has_no_files(package: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    entry = EntryPoint("gone", "no_such_package_at_all:Gone", planner_cache.GROUP)
    before = planner_cache.cache_file("?")
    monkeypatch.setattr(planner_cache, "entry_points", lambda group: [entry])
    assert planner_cache.cache_file("?") != before
