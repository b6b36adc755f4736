"""Temporary folders are removed, also those of killed processes; files of others are not read."""

import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from storage.own_files import is_own_folder, read_own
from storage.temporary import PREFIX, YOUNG, sweep_temporary_folders, temporary_folder


def age(folder: Path) -> None:
    """Make a folder look older than those that may have been created a moment ago."""
    past = folder.stat().st_mtime - 2.0 * YOUNG
    os.utime(folder, (past, past))


def test_a_folder_lasts_as_long_as_its_block(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with pytest.raises(ValueError, match="stop"), temporary_folder() as folder:
        (folder / "file").touch()
        age(folder)
        sweep_temporary_folders(tmp_path)
        assert (folder / "file").exists()
        raise ValueError("stop")
    assert list(tmp_path.iterdir()) == []


def test_the_folder_of_a_killed_process_is_swept(tmp_path: Path) -> None:
    code = (
        "import os\nfrom storage.temporary import temporary_folder\n"
        "with temporary_folder() as folder:\n    (folder / 'file').touch()\n    os.kill(os.getpid(), 9)"
    )
    killed = subprocess.run([sys.executable, "-c", code], env=os.environ | {"TMPDIR": str(tmp_path)}, check=False)
    assert killed.returncode == -signal.SIGKILL
    [left] = tmp_path.iterdir()
    sweep_temporary_folders(tmp_path)
    assert left.exists(), "it was created a moment ago, and may not be locked yet"
    age(left)
    sweep_temporary_folders(tmp_path)
    assert not left.exists()


def test_other_things_stay(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / f"{PREFIX}fifo")
    (tmp_path / "real").mkdir()
    (tmp_path / f"{PREFIX}link").symlink_to(tmp_path / "real")
    (tmp_path / "ppaas-other").mkdir()
    for path in tmp_path.iterdir():
        os.utime(path, (0, 0), follow_symlinks=False)
    before = sorted(tmp_path.iterdir())
    sweep_temporary_folders(tmp_path)
    sweep_temporary_folders(tmp_path / "none")
    assert sorted(tmp_path.iterdir()) == before


# Files in folders that strangers can write to.


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
