"""Kernels that every container uses are compiled once, before a fork server loads them."""

import os
import subprocess
import sys
from pathlib import Path

import msgspec
import pytest

import ppaas
from engine.container.warm_up import first_start
from engine.runtimes.compilation import stamp

LAYER = "tbb"


@pytest.fixture
def notes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the folder of notes on compiled kernels, still empty."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "notes"))
    return tmp_path / "notes"


@pytest.fixture
def told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the file to which a failing compiler writes its arguments."""
    file = tmp_path / "told"
    script = f"import sys; open({str(file)!r}, 'a').write(' '.join(sys.argv[1:]) + '\\n'); sys.exit(3)"
    monkeypatch.setattr(first_start, "COMMAND", (sys.executable, "-c", script))
    return file


def note_as_compiled(key: str) -> None:
    """Write a note that all kernels are compiled."""
    stamp.note(stamp.stamp_file(Path(ppaas.__path__[0]), key), [])


def test_a_compiler_that_fails_is_told_of_and_the_start_goes_on(
    notes: Path, told: Path, caplog: pytest.LogCaptureFixture
) -> None:
    first_start.compile_missing(LAYER)
    assert told.read_text() == f"{os.getpid()} {LAYER}\n"
    assert "status 3" in caplog.text


@pytest.mark.parametrize("key", [LAYER, first_start._key(LAYER)])
def test_nothing_is_started_where_all_kernels_or_those_of_containers_are_known_to_be_compiled(
    notes: Path, told: Path, key: str
) -> None:
    note_as_compiled(key)
    first_start.compile_missing(LAYER)
    assert not told.exists()


def test_those_of_another_layer_are_others(notes: Path, told: Path) -> None:
    note_as_compiled("serial")
    first_start.compile_missing(LAYER)
    assert told.exists()


def test_what_containers_use_is_compiled_and_noted(tmp_path: Path, told: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))  # notes lie there, and the cache where it did
    command = (sys.executable, "-m", first_start.__name__, str(os.getpid()), LAYER)
    subprocess.run(command, check=True, timeout=300)
    (note,) = (tmp_path / ".cache" / "ppaas").glob("*.json")
    files = [Path(file) for file in msgspec.json.decode(note.read_bytes(), type=list[str])]
    assert all(file.exists() for file in files)
    assert {"dwa", "likelihood_field", "tile_growth"} <= {file.name.partition(".")[0] for file in files}
    first_start.compile_missing(LAYER)
    assert not told.exists()
