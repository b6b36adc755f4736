import contextlib
import os
import signal
import socket
import stat
import subprocess
import sys
import tempfile

import pytest

from engine.processes import run_dir
from engine.processes.instances import instance_name
from engine.processes.run_dir import (
    LONGEST_NAME,
    LONGEST_PATH,
    OWNER,
    add_owner,
    make_run_dir,
    owners_of,
    remove_folder,
    remove_unless_owned,
    sweep_dead,
)
from ppaas.errors import InvalidInput

MADE = len("/ppaas-12345678/")


def test_folder_is_accessible_to_its_user_only(short_path):
    folder = make_run_dir()
    assert folder.parent == short_path
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700


@pytest.mark.parametrize("spare", [0, -1])
def test_longest_socket_name_fits_or_the_folder_is_refused(short_path, monkeypatch, spare):
    available = LONGEST_PATH - LONGEST_NAME - MADE - len(bytes(short_path)) - 1
    parent = short_path / ("a" * (available - spare))
    parent.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(parent))
    if spare < 0:
        with pytest.raises(InvalidInput, match="set TMPDIR to a shorter one"):
            make_run_dir()
        assert not list(parent.iterdir())
    else:
        with socket.socket(socket.AF_UNIX) as bound:
            bound.bind(str(make_run_dir() / ("s" * LONGEST_NAME)))


def test_folder_of_a_killed_process_is_removed_with_the_next_folder(short_path):
    code = "import os; from engine.processes.run_dir import make_run_dir; make_run_dir(); os.kill(os.getpid(), 9)"
    killed = subprocess.run([sys.executable, "-c", code], env=os.environ | {"TMPDIR": str(short_path)}, check=False)
    assert killed.returncode == -signal.SIGKILL
    (left,) = short_path.iterdir()
    made = make_run_dir()
    assert not left.exists()
    assert (made / OWNER).read_text().split() == [instance_name()]


def test_a_folder_is_kept_while_one_of_its_owners_runs(short_path):
    code = (
        "import sys; from pathlib import Path; from engine.processes.run_dir import add_owner;"
        "add_owner(Path(sys.argv[1]))"
    )
    made = make_run_dir()
    subprocess.run([sys.executable, "-c", code, str(made)], check=True)
    sweep_dead(short_path)
    assert made.exists(), "one owner is dead, and the other is not"
    (made / OWNER).write_text((made / OWNER).read_text().split()[-1])  # the dead owner
    remove_unless_owned(made)
    assert not made.exists()


def test_folder_with_another_owner_is_kept(short_path):
    made = make_run_dir()
    code = (
        "import sys; from pathlib import Path; from engine.processes.run_dir import add_owner, remove_unless_owned;"
        "folder = Path(sys.argv[1]); add_owner(folder); remove_unless_owned(folder)"
    )
    subprocess.run([sys.executable, "-c", code, str(made)], check=True)
    assert made.exists()


def test_folders_of_running_processes_and_without_owners_are_kept(short_path):
    mine, nobodys = make_run_dir(), short_path / "ppaas-notes"
    nobodys.mkdir()
    (short_path / "ppaas-file").write_text("notes")
    sweep_dead(short_path)
    assert mine.exists() and nobodys.exists()


def test_a_folder_of_a_process_killed_before_it_owned_it_is_removed_once_nobody_can_be_making_it(short_path):
    names = ("ppaas-abcd_123", "ppaas-with0one", "ppaas-check-abcd_123", "ppaas-longer_name")
    made, full, other, longer = (short_path / name for name in names)
    for folder in (made, full, other, longer):
        folder.mkdir()
    (full / "socket").touch()
    sweep_dead(short_path)
    assert made.exists(), "a process may own it in a moment"
    for folder in (made, full, other, longer):
        os.utime(folder, (0.0, 0.0))
    sweep_dead(short_path)
    assert not made.exists()
    assert full.exists()
    assert other.exists()
    assert longer.exists()


def test_a_process_whose_folder_was_swept_while_it_was_stopped_makes_another(short_path, monkeypatch):
    made = []

    def swept_at_first(folder):
        made.append(folder)
        if len(made) == 1:
            folder.rmdir()
        add_owner(folder)

    monkeypatch.setattr(run_dir, "add_owner", swept_at_first)
    assert make_run_dir() == made[1]
    assert owners_of(made[1]) == [instance_name()]


def test_the_list_of_owners_is_removed_last(short_path, monkeypatch):
    folder = make_run_dir()
    (folder / "folder").mkdir()
    (folder / "a-socket").touch()
    (folder / "link").symlink_to(short_path)
    before = run_dir.shutil.rmtree

    def killed_at_the_folder(path, **others):
        if path == folder:
            raise KeyboardInterrupt
        before(path, **others)

    monkeypatch.setattr(run_dir.shutil, "rmtree", killed_at_the_folder)
    with pytest.raises(KeyboardInterrupt):
        remove_folder(folder)
    assert [entry.name for entry in folder.iterdir()] == [OWNER]
    assert short_path.exists(), "links are not followed"


def test_folder_of_temporary_files_is_removed_at_exit(short_path):
    folder = short_path / "kept"
    folder.mkdir()
    script = (
        "import sys; from pathlib import Path; from multiprocessing.util import get_temp_dir\n"
        "from engine.processes.run_dir import keep_temporary_files_in, remove_folder\n"
        "folder = Path(sys.argv[1]); keep_temporary_files_in(folder); remove_folder(folder)\n"
        "assert Path(get_temp_dir()).parent == folder"
    )
    command = [sys.executable, "-c", script, str(folder)]
    done = subprocess.run(command, check=False, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, "")
    assert not folder.exists()


def test_other_folder_is_removed_at_once(short_path):
    (short_path / "other" / "in it").mkdir(parents=True)
    remove_folder(short_path / "other")
    assert not (short_path / "other").exists()


@pytest.mark.parametrize("kind", ["fifo", "device", "link", "folder", "huge"])
def test_nothing_but_a_regular_file_is_read_as_the_list_of_owners(short_path, kind):
    owner = short_path / "ppaas-x" / OWNER
    owner.parent.mkdir()
    dead = short_path / "dead"
    dead.write_text(f"{instance_name()}0\n")
    if kind == "fifo":
        os.mkfifo(owner)
    elif kind == "device":
        owner.symlink_to("/dev/zero")
    elif kind == "link":
        owner.symlink_to(dead)
    elif kind == "folder":
        owner.mkdir()
    else:
        owner.write_bytes(dead.read_bytes())
        os.truncate(owner, 1 << 40)
    sweep_dead(short_path)
    remove_unless_owned_or_report(owner.parent)
    assert owner.parent.exists()


def remove_unless_owned_or_report(folder):
    with contextlib.suppress(OSError):
        remove_unless_owned(folder)


def test_a_link_to_a_folder_of_a_dead_process_stays(short_path):
    real = short_path / "real"
    real.mkdir()
    (real / OWNER).write_text(f"{instance_name()}0\n")
    (short_path / "ppaas-link").symlink_to(real)
    sweep_dead(short_path)
    assert (real / OWNER).exists()


@pytest.mark.skipif(os.geteuid() != 0, reason="only root gives files away")
def test_folders_of_other_users_are_not_looked_into(short_path):
    folder = short_path / "ppaas-x"
    folder.mkdir()
    (folder / OWNER).write_text(f"{instance_name()}0\n")
    os.chown(folder, 65534, 65534)
    sweep_dead(short_path)
    assert folder.exists()
