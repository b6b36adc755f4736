"""Files that commands write, and the reason if they cannot."""

import os
from pathlib import Path

import pytest

from ppaas.errors import InvalidInput
from robots.cli.output_files import check_folder, write_file


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
