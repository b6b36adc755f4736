"""Catalogue of installed planners, listed by a separate process."""

import sys
from pathlib import Path

import pytest

from endpoints.services import installed_planners
from endpoints.services.installed_planners import InstalledPlanners
from ppaas.errors import Unavailable

TOLD = ("-c", """import sys; sys.stdout.write('[{"name": "straight"}]')""")


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr(installed_planners, "PROGRAM", TOLD)


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
