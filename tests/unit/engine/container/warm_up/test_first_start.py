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
def arguments(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the file to which a failing compiler writes its arguments."""
    file = tmp_path / "arguments"
    script = f"import sys; open({str(file)!r}, 'a').write(' '.join(sys.argv[1:]) + '\\n'); sys.exit(3)"
    monkeypatch.setattr(first_start, "COMMAND", (sys.executable, "-c", script))
    return file


def note_as_compiled(key: str) -> None:
    """Write a note that all kernels are compiled."""
    stamp.note(stamp.stamp_file(Path(ppaas.__path__[0]), key), [])


def test_failing_compiler_is_logged_and_the_start_continues(
    notes: Path, arguments: Path, caplog: pytest.LogCaptureFixture
) -> None:
    first_start.compile_missing(LAYER)
    assert arguments.read_text() == f"{os.getpid()} {LAYER}\n"
    assert "status 3" in caplog.text


@pytest.mark.parametrize("key", [LAYER, first_start._key(LAYER)])
def test_compiler_is_not_started_if_kernels_are_noted_as_compiled(notes: Path, arguments: Path, key: str) -> None:
    note_as_compiled(key)
    first_start.compile_missing(LAYER)
    assert not arguments.exists()


def test_notes_of_another_threading_layer_do_not_count(notes: Path, arguments: Path) -> None:
    note_as_compiled("serial")
    first_start.compile_missing(LAYER)
    assert arguments.exists()


def test_kernels_of_containers_are_compiled_and_noted(
    tmp_path: Path, arguments: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))  # the notes are written there, and the cache stays in place
    command = (sys.executable, "-m", first_start.__name__, str(os.getpid()), LAYER)
    subprocess.run(command, check=True, timeout=300)
    (note,) = (tmp_path / ".cache" / "ppaas").glob("*.json")
    files = [Path(file) for file in msgspec.json.decode(note.read_bytes(), type=list[str])]
    assert all(file.exists() for file in files)
    assert {"dwa", "likelihood_field", "tile_growth", "chain_code", "pose_text"} <= {
        file.name.partition(".")[0] for file in files
    }
    first_start.compile_missing(LAYER)
    assert not arguments.exists()


def test_modules_are_listed_without_compiling_kernels_of_declared_types(tmp_path: Path) -> None:
    script = (
        "from engine.container.warm_up import first_start\n"
        "from engine.runtimes.compilation import compile_pool\n"
        "print(*compile_pool._largest_first(first_start._names))\n"
    )
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    listed = subprocess.run(
        [sys.executable, "-c", script], env=environment, check=True, capture_output=True, text=True, timeout=300
    ).stdout.split()
    assert {"ppaas.costmap.kernels.obstacle", "ppaas.maps.kernels.raycast"} <= set(listed)
    assert not list(tmp_path.rglob("*.nbi"))


def test_a_compiler_that_is_killed_is_started_again(
    notes: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    starts = tmp_path / "starts"
    script = (
        f"import os; open({str(starts)!r}, 'a').write('x')\n"
        f"if len(open({str(starts)!r}).read()) < 3: os.kill(os.getpid(), 9)"
    )
    monkeypatch.setattr(first_start, "COMMAND", (sys.executable, "-c", script))
    first_start.compile_missing(LAYER)
    assert (starts.read_text(), caplog.text.count("killed by signal 9")) == ("xxx", 2)
    assert "status" not in caplog.text
