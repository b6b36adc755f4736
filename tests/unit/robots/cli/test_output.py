import json
import os
import re
from pathlib import Path

import pytest
from rich.console import Console

from ppaas.errors import InvalidInput
from robots.cli.output import cell, show
from robots.cli.output_files import check_folder, write_file
from robots.cli.progress import progress_bar

MAPS = [
    {"id": "house", "version": "0123456789abcdef", "origin": [-1.0, 2.0, 0.5], "readers": []},
    {"id": "a-longer-name", "version": None, "origin": [], "readers": ["ann", "*"]},
]


def test_columns_are_as_wide_as_their_widest_cell(capsys: pytest.CaptureFixture[str]) -> None:
    show(MAPS, ("id", "version", "origin", "readers"), as_json=False)
    assert capsys.readouterr().out.splitlines() == [
        "id             version       origin      readers",
        "house          0123456789ab  -1, 2, 0.5  -",
        "a-longer-name  -             -           ann, *",
    ]


def test_one_object_is_a_table_of_one_row(capsys: pytest.CaptureFixture[str]) -> None:
    container = {"id": "c1", "map": {"id": "house", "version": "v"}, "cores": 0.5, "pss": 3 << 20, "kind": "robot"}
    show(container, ("id", "map", "cores", "pss"), as_json=False)
    assert capsys.readouterr().out == "id  map    cores  pss\nc1  house  0.5    3.0 MiB\n"


def test_memory_is_shown_in_units(capsys: pytest.CaptureFixture[str]) -> None:
    show({"memory": 24 << 30, "memory_used": 512 << 20}, ("memory", "memory_used"), as_json=False)
    assert capsys.readouterr().out.splitlines()[1] == "24.0 GiB  512.0 MiB"


def test_an_empty_list_prints_a_sentence_or_an_empty_json_list(capsys: pytest.CaptureFixture[str]) -> None:
    show([], ("id",), as_json=False, if_none="no maps")
    show([], ("id",), as_json=True, if_none="no maps")
    assert capsys.readouterr().out == "no maps\n[]\n"


def test_json_contains_the_whole_answer(capsys: pytest.CaptureFixture[str]) -> None:
    show(MAPS, ("id",), as_json=True)
    assert json.loads(capsys.readouterr().out) == MAPS


def test_the_progress_of_kernels_is_a_count() -> None:
    assert cell("kernels", {"done": 12, "total": 107, "compiling": ["lattice/driving"]}) == "12 of 107"
    assert cell("kernels", None) == "-"


def test_a_file_is_written_and_replaced_with_its_mode(tmp_path: Path) -> None:
    path = tmp_path / "out.yaml"
    write_file(path, b"one")
    assert path.stat().st_mode & 0o777 == 0o666 & ~_umask()
    path.chmod(0o640)
    write_file(path, b"two")
    assert (path.read_bytes(), path.stat().st_mode & 0o777) == (b"two", 0o640)
    assert list(tmp_path.iterdir()) == [path]


def test_an_interrupted_write_leaves_the_file_as_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "out.yaml"
    path.write_bytes(b"before")

    def interrupted(self: Path, content: bytes) -> int:
        self.touch()
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "write_bytes", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_file(path, b"after")
    assert path.read_bytes() == b"before"
    assert list(tmp_path.iterdir()) == [path]


def test_a_link_stays_one_and_devices_are_written_to(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    link = tmp_path / "link"
    link.symlink_to(tmp_path / "there" / "out")
    write_file(link, b"x")
    assert link.is_symlink() and (tmp_path / "there" / "out").read_bytes() == b"x"
    write_file(Path(os.devnull), b"x")
    assert Path(os.devnull).is_char_device()


def test_a_missing_folder_is_named(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match=r"there is no folder .*absent"):
        check_folder(tmp_path / "absent" / "map.pgm")


def test_a_path_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "absent" / "map.pgm"):
        with pytest.raises(InvalidInput, match="cannot write the file"):
            write_file(path, b"")


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def test_without_a_terminal_nothing_is_shown(capsys: pytest.CaptureFixture[str]) -> None:
    with progress_bar("publish office") as report:
        assert report is None
    assert capsys.readouterr().err == ""


def test_a_terminal_shows_what_is_done(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(Console, "is_terminal", True)
    with progress_bar("publish office") as report:
        assert report is not None
        report("draw the map", 0.5)
    assert "publish office: draw the map" in capsys.readouterr().err


@pytest.mark.parametrize("column", ["since", "last_run", "before", "time"])
def test_times_are_dates(column: str) -> None:
    assert re.fullmatch(r"2026-\d\d-\d\d \d\d:\d\d:\d\d", cell(column, 1796030000.0))
