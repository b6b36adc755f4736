"""Notes on the modules of one cache are shared by all its compilers."""

import multiprocessing
from multiprocessing.connection import Connection
from pathlib import Path

import pytest

from engine.runtimes.compilation.stamp import ModuleNotes


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
