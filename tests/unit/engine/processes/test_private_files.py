"""Files of a cloud are private to its user.

The kind is "other users of the host". Its members: the data folder with maps, stores and keys; lock files and the
outbox; sockets and layers of maps; the password file; half-made files; files that Docker containers, which run as
another user, have to read.
"""

import errno
import os
import stat
from collections.abc import Iterator
from pathlib import Path

import pytest

from engine.processes.disk_notes import exclusive, write_note
from engine.processes.private_files import keep_new_files_private, make_private_folder, warn_if_open, write_private


def mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


@pytest.fixture
def usual_umask() -> Iterator[None]:
    before = os.umask(0o022)
    yield
    os.umask(before)


@pytest.mark.usefixtures("usual_umask")
def test_a_new_folder_is_for_its_user_only(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    make_private_folder(tmp_path / "data")
    assert mode(tmp_path / "data") == 0o700
    assert not caplog.records


@pytest.mark.usefixtures("usual_umask")
def test_an_existing_folder_that_others_may_enter_is_reported_and_not_changed(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "data").mkdir(mode=0o755)
    make_private_folder(tmp_path / "data")
    assert mode(tmp_path / "data") == 0o755
    assert f"(mode 0755): run 'chmod -R go= {tmp_path / 'data'}'" in caplog.text


def test_a_file_that_others_may_read_is_reported(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    (tmp_path / "password").touch()
    (tmp_path / "password").chmod(0o640)
    warn_if_open(tmp_path / "password")
    assert f"(mode 0640): run 'chmod go= {tmp_path / 'password'}'" in caplog.text


@pytest.mark.usefixtures("usual_umask")
def test_files_that_a_process_makes_afterwards_are_private(tmp_path: Path) -> None:
    keep_new_files_private()
    write_note(tmp_path / "notes" / "note.json", 1)
    with exclusive(tmp_path / "locks" / "one.lock"):
        pass
    (tmp_path / "plain").write_text("x")
    assert {mode(path) for path in tmp_path.rglob("*")} == {0o600, 0o700}


@pytest.mark.usefixtures("usual_umask")
def test_a_private_file_is_private_from_its_first_byte(tmp_path: Path) -> None:
    write_private(tmp_path / "key", b"secret")
    assert mode(tmp_path / "key") == 0o600
    assert list(tmp_path.iterdir()) == [tmp_path / "key"]


def test_a_private_file_that_does_not_fit_leaves_the_old_one_and_no_part(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    write_private(tmp_path / "key", b"old")
    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space left"):
        write_private(tmp_path / "key", b"new")
    assert [path.read_bytes() for path in tmp_path.iterdir()] == [b"old"]
