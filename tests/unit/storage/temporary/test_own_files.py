"""Files in folders that strangers can write to."""

import os
from pathlib import Path

import pytest

from storage.temporary.own_files import is_own_folder, read_own


def test_a_regular_file_is_read_up_to_the_limit(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"12345")
    assert read_own(tmp_path / "file", 100) == b"12345"
    assert read_own(tmp_path / "file", 3) == b"123"


def test_a_fifo_a_link_and_a_device_are_refused_at_once(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "fifo")
    (tmp_path / "file").touch()
    (tmp_path / "link").symlink_to(tmp_path / "file")
    for path in (tmp_path / "fifo", tmp_path / "link", tmp_path, tmp_path / "none", Path("/dev/zero")):
        with pytest.raises(OSError):
            read_own(path, 1)


def test_only_a_real_folder_of_this_user_is_its_own(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(tmp_path)
    (tmp_path / "file").touch()
    assert is_own_folder(tmp_path)
    assert not any(map(is_own_folder, (tmp_path / "link", tmp_path / "file", tmp_path / "none")))


@pytest.mark.skipif(os.geteuid() != 0, reason="only root gives files away")
def test_files_and_folders_of_others_are_not_its_own(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    (tmp_path / "folder").mkdir()
    for path in (tmp_path / "file", tmp_path / "folder"):
        os.chown(path, 65534, 65534)
    with pytest.raises(PermissionError):
        read_own(tmp_path / "file", 1)
    assert not is_own_folder(tmp_path / "folder")
