"""The stamp file is valid until a kernel or its file changes; compilers of a cache share notes on its modules."""

import multiprocessing
import os
import sys
from multiprocessing.connection import Connection
from pathlib import Path
from types import ModuleType

import pytest

from engine.runtimes.compilation import stamp as kernel_stamp
from engine.runtimes.compilation.stamp import ModuleNotes

KERNEL = """
from numba import njit

@njit(cache=True)
def twice(number):
    return 2 * number

@njit(cache=True)
def never_called(number):
    return number

def warm():
    twice(1)
"""


@pytest.fixture
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the folder of a package with one kernel module, with its own cache for notes."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    folder = tmp_path / "domain" / "room" / "kernels"
    folder.mkdir(parents=True)
    (folder / "doubling.py").write_text(KERNEL)
    (tmp_path / "domain" / "room" / "other.py").write_text("")
    return tmp_path / "domain"


@pytest.fixture
def module(root: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """Return that module, called."""
    monkeypatch.syspath_prepend(root / "room" / "kernels")
    monkeypatch.delitem(sys.modules, "doubling", raising=False)
    import doubling  # type: ignore[import-not-found]

    doubling.warm()
    return doubling


def test_kernels_without_a_stamp_count_as_not_compiled(root: Path) -> None:
    assert not kernel_stamp.all_compiled(kernel_stamp.stamp_file(root, "tbb"))


def test_a_stamp_is_valid_until_a_kernel_changes(root: Path, module: ModuleType) -> None:
    stamp = kernel_stamp.stamp_file(root, "tbb")
    kernel_stamp.note(stamp, kernel_stamp.cache_files(module))
    assert kernel_stamp.all_compiled(stamp)
    assert kernel_stamp.stamp_file(root, "serial") != stamp
    (root / "room" / "other.py").write_text("changed = 1")
    assert kernel_stamp.stamp_file(root, "tbb") == stamp
    kernel = root / "room" / "kernels" / "doubling.py"
    os.utime(kernel, ns=(1, 1))
    assert kernel_stamp.stamp_file(root, "tbb") == stamp, "numba goes by the content, too"
    kernel.write_text(KERNEL + "#")
    assert kernel_stamp.stamp_file(root, "tbb") != stamp


def test_stamp_lists_called_kernels_only(module: ModuleType) -> None:
    (file,) = kernel_stamp.cache_files(module)
    assert Path(file).name.startswith("doubling.twice-")


def test_missing_cache_file_invalidates_the_stamp(root: Path, module: ModuleType) -> None:
    stamp = kernel_stamp.stamp_file(root, "tbb")
    kernel_stamp.note(stamp, kernel_stamp.cache_files(module))
    (file,) = kernel_stamp.cache_files(module)
    Path(file).unlink()
    assert not kernel_stamp.all_compiled(stamp)
    stamp.unlink()
    kernel_stamp.note(stamp, [file])
    assert not stamp.exists(), "missing cache files are not noted"


@pytest.mark.parametrize("rubbish", [b"", b"{", b"[1]", b"\xff"])
def test_an_unreadable_stamp_is_ignored(root: Path, rubbish: bytes) -> None:
    stamp = kernel_stamp.stamp_file(root, "tbb")
    stamp.parent.mkdir()
    stamp.write_bytes(rubbish)
    assert not kernel_stamp.all_compiled(stamp)


def test_unwritable_stamp_is_not_an_error(module: ModuleType) -> None:
    kernel_stamp.note(Path(os.devnull) / "note.json", kernel_stamp.cache_files(module))


@pytest.fixture
def stamp(tmp_path: Path) -> Path:
    return tmp_path / "notes" / "compiled-1.json"


@pytest.fixture
def index(tmp_path: Path) -> Path:
    """Return an index file in the cache."""
    file = tmp_path / "one.nbi"
    file.touch()
    return file


def test_what_one_process_notes_another_one_knows(stamp: Path, index: Path) -> None:
    ModuleNotes(stamp).note("a.kernels.one", [str(index)])
    assert ModuleNotes(stamp).compiled() == {"a.kernels.one": [str(index)]}


def test_a_module_whose_files_were_removed_is_not_compiled(stamp: Path, index: Path) -> None:
    ModuleNotes(stamp).note("a.kernels.one", [str(index)])
    index.unlink()
    assert ModuleNotes(stamp).compiled() == {}


def test_a_module_is_wanted_until_it_is_compiled(stamp: Path, index: Path) -> None:
    here, there = ModuleNotes(stamp), ModuleNotes(stamp)
    here.want(["a.kernels.one", "a.kernels.two"])
    assert there.wanted() == {"a.kernels.one", "a.kernels.two"}
    there.note("a.kernels.one", [str(index)])
    assert here.wanted() == {"a.kernels.two"}


def test_compiled_modules_are_not_wanted_again(stamp: Path, index: Path) -> None:
    notes = ModuleNotes(stamp)
    notes.note("a.kernels.one", [str(index)])
    notes.want(["a.kernels.one"])
    assert notes.wanted() == set()


def test_without_a_folder_this_process_alone_knows(tmp_path: Path, index: Path) -> None:
    (tmp_path / "file").touch()
    notes = ModuleNotes(tmp_path / "file" / "compiled-1.json")
    notes.want(["a.kernels.two"])
    notes.note("a.kernels.one", [str(index)])
    assert (set(notes.compiled()), notes.wanted()) == ({"a.kernels.one"}, {"a.kernels.two"})
    with notes.turn() as mine:
        assert mine


def _try(stamp: Path, answer: Connection) -> None:
    with ModuleNotes(stamp).turn() as mine:
        answer.send(mine)


def test_one_process_at_a_time_has_its_turn(stamp: Path) -> None:
    spawning = multiprocessing.get_context("spawn")
    receiving, sending = spawning.Pipe(duplex=False)
    with ModuleNotes(stamp).turn() as mine:
        process = spawning.Process(target=_try, args=(stamp, sending))
        process.start()
        assert (mine, receiving.recv()) == (True, False)
        process.join()
    with ModuleNotes(stamp).turn() as mine:
        assert mine
