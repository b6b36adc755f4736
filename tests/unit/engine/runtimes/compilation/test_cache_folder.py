"""Kernels are cached in memory, for one run, if no other folder can be written."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from engine.runtimes.compilation import cache_folder
from engine.runtimes.compilation.cache_folder import ensure_cache


@pytest.fixture
def nothing_writable(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a path in which nothing can be created, that of a file; sources, home and cache are there."""
    file = tmp_path / "file"
    file.touch()
    monkeypatch.setattr(cache_folder.ppaas, "__path__", [str(file)])
    monkeypatch.setenv("HOME", str(file))
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setattr(cache_folder, "SHARED_MEMORY", tmp_path / "shm")
    monkeypatch.setattr(cache_folder.atexit, "register", lambda *_arguments, **_options: None)
    return file


def test_a_folder_in_memory_replaces_those_that_cannot_be_written(
    nothing_writable: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    ensure_cache()
    folder = Path(os.environ["NUMBA_CACHE_DIR"])
    assert folder.is_dir() and folder.is_relative_to(tmp_path / "shm")
    assert caplog.text.count("kept in memory") == 1
    ensure_cache()  # a child of this process has a cache
    assert caplog.text.count("kept in memory") == 1


@pytest.mark.parametrize("variable", ["HOME", "XDG_CACHE_HOME", "NUMBA_CACHE_DIR"])
def test_a_folder_that_can_be_written_stays(
    nothing_writable: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, variable: str
) -> None:
    monkeypatch.setenv(variable, str(tmp_path / "own"))
    before = os.environ.get("NUMBA_CACHE_DIR")
    ensure_cache()
    assert os.environ.get("NUMBA_CACHE_DIR") == before


def test_a_given_folder_that_cannot_be_written_is_replaced(
    nothing_writable: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(nothing_writable / "cache"))
    ensure_cache()
    assert Path(os.environ["NUMBA_CACHE_DIR"]).is_relative_to(tmp_path / "shm")


def test_the_folder_goes_with_its_process(tmp_path: Path) -> None:
    script = (
        "import os, pathlib\n"
        "from engine.runtimes.compilation import cache_folder\n"
        f"cache_folder.SHARED_MEMORY = pathlib.Path({str(tmp_path)!r})\n"
        "cache_folder._usual = lambda: iter(())\n"
        "cache_folder.ensure_cache()\n"
        "assert pathlib.Path(os.environ['NUMBA_CACHE_DIR']).is_dir()\n"
    )
    subprocess.run([sys.executable, "-c", script], check=True)
    assert list(tmp_path.iterdir()) == []
