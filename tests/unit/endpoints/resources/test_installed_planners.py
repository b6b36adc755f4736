"""Catalogue of installed planners, listed by a separate process."""

import sys
from pathlib import Path

import pytest

from endpoints.resources import installed_planners, list_planners
from endpoints.resources.installed_planners import InstalledPlanners
from ppaas.errors import Unavailable

LISTING = ("-c", """import sys; sys.stdout.write('[{"name": "straight"}]')""")


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr(installed_planners, "PROGRAM", LISTING)


async def test_installed_planners_are_cached_across_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    first = await InstalledPlanners().all()
    assert first == [{"name": "straight"}]
    monkeypatch.setattr(sys, "executable", "/no/such/python")
    assert await InstalledPlanners().all() == first


async def test_a_damaged_cache_file_is_rebuilt(tmp_path: Path) -> None:
    await InstalledPlanners().all()
    [file] = (tmp_path / "cache").rglob("planners*")
    for broken in (b"", b"{}", b'[{"name": "str'):
        file.write_bytes(broken)
        assert await InstalledPlanners().all() == [{"name": "straight"}]


async def test_an_error_is_not_cached(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(installed_planners, "PROGRAM", ("-c", "raise ImportError('not yet')"))
    with pytest.raises(Unavailable):
        await InstalledPlanners().all()
    assert list((tmp_path / "cache").rglob("planners*")) == []


async def test_planners_are_listed_without_a_writable_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a file").touch()
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "a file" / "cache"))
    assert await InstalledPlanners().all() == [{"name": "straight"}]


async def test_a_planner_that_cannot_be_loaded_is_left_out_and_tried_again_at_the_next_start(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    code = f"{LISTING[1]}; sys.stderr.write('planner crooked'); sys.exit({list_planners.INCOMPLETE})"
    monkeypatch.setattr(installed_planners, "PROGRAM", ("-c", code))
    assert await InstalledPlanners().all() == [{"name": "straight"}]
    assert "planner crooked" in caplog.text
    assert list((tmp_path / "cache").rglob("planners*")) == []
