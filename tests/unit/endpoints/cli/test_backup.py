"""``ppaas backup`` and ``ppaas restore``."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import msgspec
import pytest

from robots import cli
from robots.cli import main
from storage import temporary
from storage.backup.manifest import FORMAT, FORMAT_OF_RECORDS
from storage.backup.repository import LOCK, Repository
from storage.urls.opening import open_map_store, open_store
from tests.support.storage.full_store import fill, fill_maps
from tests.support.storage.records import plan, user


@pytest.fixture
def data(tmp_path: Path) -> Path:
    """Return a data folder with full stores."""
    folder = tmp_path / "data"
    store = open_store(f"sqlite://{folder}/ppaas.sqlite")
    fill(store)
    store.close()
    fill_maps(open_map_store(f"file://{folder}/maps"))
    return folder


KEYS = {"machines/authority.key": b"secret", "machines/cloud.pem": b"pem", "machine-settings.json": b"{}"}
RECORDED = {
    "recordings/ann/tb1/20261126T224142Z.mcap": b"x" * 9_000_000, "recordings/bob/tb2/20261127T224142Z-2.mcap": b"y"
}  # fmt: skip
LEFT = ("recordings/ann/tb1/20261126T224143Z.partial", "recordings/ann/tb1/ring/7.mcap", "machines/notes.txt")


@pytest.fixture
def files(data: Path) -> Path:
    """Return the data folder with keys of machines, recordings, and files that no backup has."""
    for name, content in (KEYS | RECORDED | dict.fromkeys(LEFT, b"left")).items():
        path = data / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
        os.utime(path, (1e9, 1e9))
    return data


@pytest.fixture
def place(tmp_path: Path) -> str:
    return str(tmp_path / "backups")


def back_up(place: str, data: Path, capsys: pytest.CaptureFixture[str], *options: str) -> dict[str, Any]:
    assert main.main(["backup", place, "--data", str(data), "--json", *options]) == 0
    [row] = json.loads(capsys.readouterr().out)
    assert isinstance(row, dict)
    return row


def test_a_backup_is_restored_into_an_empty_data_folder(
    data: Path, place: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    row = back_up(place, data, capsys)
    assert row["at_once"]
    assert row["stores"] == {"store": "sqlite", "map_store": "file"}
    new = tmp_path / "new"
    assert main.main(["restore", place, "--data", str(new)]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()][-1] == "maps"
    for store in ("sqlite://{}/ppaas.sqlite", "file://{}/maps"):
        assert main.main(["store", "check", store.format(data), store.format(new)]) == 0
    assert not [each for each in data.iterdir() if each.name.startswith("ppaas-map-")], "the copy is removed"


def test_restoring_keeps_records_that_differ_unless_they_are_overwritten(
    data: Path, place: str, capsys: pytest.CaptureFixture[str]
) -> None:
    back_up(place, data, capsys)
    store = open_store(f"sqlite://{data}/ppaas.sqlite")
    store.change_user(user("bob", password_hash="changed"))
    store.remove_plan("p00001")
    store.close()
    assert main.main(["restore", place, "--data", str(data)]) == 1
    assert "differs or is missing: users bob" in capsys.readouterr().out
    assert main.main(["restore", place, "--data", str(data), "--overwrite", "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert (result["good"], result["left_out"]) == (True, {})
    assert {kind["kind"]: kind["copied"] for kind in result["kinds"]}["users"] == 1


def test_old_backups_are_removed_and_the_rest_is_whole(
    data: Path, place: str, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = [back_up(place, data, capsys)]
    for number in range(3):
        store = open_store(f"sqlite://{data}/ppaas.sqlite")
        store.add_plan(plan(f"later{number}"))
        store.close()
        rows.append(back_up(place, data, capsys, "--keep", "3"))
    assert main.main(["backup", "list", place, "--json"]) == 0
    assert [row["id"] for row in json.loads(capsys.readouterr().out)] == [row["id"] for row in rows[1:]]
    assert main.main(["backup", "remove", place, rows[1]["id"]]) == 0
    assert main.main(["backup", "remove", place, "--keep", "1", "--json"]) == 0
    assert json.loads(capsys.readouterr().out.splitlines()[-1])["removed"] == [rows[2]["id"]]
    assert main.main(["backup", "check", place]) == 0
    assert "0 damaged" in capsys.readouterr().out
    assert main.main(["backup", "list", place]) == 0
    header, row = capsys.readouterr().out.splitlines()
    assert header.split()[0] == "id"
    assert rows[3]["id"] in row


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["backup", "list", "{missing}"], "unknown repository of backups"),
        (["backup", "remove", "{place}"], "--keep NUMBER"),
        (["backup", "remove", "{place}", "20000101T000000Z-000000"], "unknown backup"),
        (["backup", "{place}", "--data", "{missing}"], "unknown store"),
        (["restore", "{place}", "--backup", "none", "--data", "{missing}"], "unknown backup"),
        (["backup", "ftp://host/place"], "give a folder, or a URL of s3:, gs: or az:"),
    ],
)
def test_mistakes_are_named(
    data: Path, place: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], text: str
) -> None:
    back_up(place, data, capsys)
    given = [each.format(place=place, missing=tmp_path / "missing") for each in arguments]
    assert main.main(given) == 1
    assert text in capsys.readouterr().err
    assert not (tmp_path / "missing").exists()


def test_a_damaged_backup_is_reported(data: Path, place: str, capsys: pytest.CaptureFixture[str]) -> None:
    row = back_up(place, data, capsys)
    name = Repository.at(place).manifest(row["id"]).streams["users"].blocks[0].name
    Path(place, "blocks", name[:2], name).write_bytes(b"nothing")
    assert main.main(["backup", "check", place, "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert (found["good"], len(found["damaged"])) == (False, 1)
    assert main.main(["restore", place, "--data", str(data)]) == 1
    assert "is damaged" in capsys.readouterr().err


@pytest.mark.parametrize("after", ["users", "plans", "maps"])
def test_a_backup_that_was_killed_is_taken_up_by_the_next(
    data: Path,
    place: str,
    after: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(temporary, "YOUNG", -1.0)
    count = {"users": 1, "plans": 14, "maps": 19}[after]
    code = f"""
import os, signal
from storage.backup.repository import LOCK, Repository
put = Repository.put
count = 0
def counted(self, data):
    global count
    count += 1
    if count == {count}:
        self.settle()
        os.kill(os.getpid(), signal.SIGKILL)
    return put(self, data)
Repository.put = counted
from robots import cli
from robots.cli import main
main.main(["backup", {place!r}, "--data", {str(data)!r}])
"""
    done = subprocess.run([sys.executable, "-c", code], check=False, timeout=120)
    assert done.returncode == -signal.SIGKILL
    assert Repository.at(place).ids() == []
    back_up(place, data, capsys)
    assert main.main(["restore", place, "--data", str(tmp_path / "new")]) == 0
    assert main.main(["store", "check", f"sqlite://{data}/ppaas.sqlite", f"sqlite://{tmp_path}/new/ppaas.sqlite"]) == 0
    assert not [each for each in data.iterdir() if each.name.startswith("ppaas-map-")], "the copy is removed"


def test_backups_are_repeated_until_sigterm_and_after_errors(data: Path, place: str, tmp_path: Path) -> None:
    away = data.rename(tmp_path / "away")
    command = [sys.executable, "-m", cli.__name__, "backup", place, "--data", str(data), "--every", "0.001", "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None and process.stdout is not None
        assert "the next backup is in 0.001 h" in process.stderr.readline()
        away.rename(data)
        for _ in range(2):
            assert json.loads(process.stdout.readline())[0]["records"]["plans"] == 80
        process.terminate()
        assert process.wait(20) == 0
    assert len(Repository.at(place).ids()) >= 2
    assert not Path(place, LOCK).exists()


@pytest.mark.parametrize("hours", ["0", "-1", "nan", "soon"])
def test_a_period_that_is_none_is_refused(place: str, hours: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main.main(["backup", place, "--every", hours])
    assert "--every" in capsys.readouterr().err


# -- files -------------------------------------------------------------------------------------------------------------


def files_in(folder: Path) -> dict[str, bytes]:
    found = [path for top in ("machines", "recordings") for path in (folder / top).rglob("*") if path.is_file()]
    settings = folder / "machine-settings.json"
    found += [settings] if settings.exists() else []
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in found}


def test_keys_and_recordings_are_restored_for_their_owner_alone(
    files: Path, place: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    key = ["--key-file", str(tmp_path / "key")]
    row = back_up(place, files, capsys, "--recordings", "--machine-keys", *key)
    assert row["files"] == len(KEYS | RECORDED)
    again = back_up(place, files, capsys, "--recordings", "--machine-keys", *key)
    assert again["added"] < 1000
    assert main.main(["backup", "check", place, *key]) == 0
    new = tmp_path / "new"
    assert main.main(["restore", place, "--data", str(new), *key]) == 0
    assert files_in(new) == KEYS | RECORDED
    for name in KEYS | RECORDED:
        found = (new / name).stat()
        assert (found.st_mode & 0o777, found.st_mtime) == (0o600, 1e9)
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()][-1] == "files"


def test_files_that_differ_stay_unless_they_are_overwritten(
    files: Path, place: str, capsys: pytest.CaptureFixture[str]
) -> None:
    back_up(place, files, capsys, "--recordings")
    name, other = sorted(RECORDED)
    (files / name).write_bytes(b"changed")
    (files / other).unlink()
    assert main.main(["restore", place, "--data", str(files), "--json"]) == 1
    [row] = [each for each in json.loads(capsys.readouterr().out)["kinds"] if each["kind"] == "files"]
    assert (row["copied"], row["same"], row["different"], row["named"]) == (1, 1, 1, [name])
    assert main.main(["restore", place, "--data", str(files), "--overwrite"]) == 0
    assert files_in(files).items() >= RECORDED.items()


def test_keys_are_backed_up_encrypted_only(files: Path, place: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main.main(["backup", place, "--data", str(files), "--machine-keys"]) == 1
    assert "encrypted only: give --key-file" in capsys.readouterr().err
    assert not Path(place).exists()


def test_without_the_options_no_file_is_backed_up(files: Path, place: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert back_up(place, files, capsys)["files"] == 0
    assert Repository.at(place).manifest("latest").format == FORMAT_OF_RECORDS
    assert back_up(place, files, capsys, "--recordings")["files"] == len(RECORDED)
    assert Repository.at(place).manifest("latest").format == FORMAT, "an earlier release refuses it"


@pytest.mark.parametrize("name", ["../outside", "/etc/outside", "machines/../../outside", ""])
def test_no_file_is_restored_outside_of_the_data_folder(
    files: Path, place: str, tmp_path: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    back_up(place, files, capsys, "--recordings")
    repository = Repository.at(place)
    manifest = repository.manifest("latest")
    [file, *_] = manifest.files
    odd = msgspec.structs.replace(manifest, id="9", files=(msgspec.structs.replace(file, name=name),))
    repository.add(odd)
    assert main.main(["restore", place, "--data", str(tmp_path / "new" / "data")]) == 1
    assert "is no file of a data folder" in capsys.readouterr().err
    assert not list(tmp_path.rglob("outside"))


@pytest.mark.parametrize("after", ["users", "plans", "maps", "files"])
def test_a_restoration_that_was_killed_is_completed_by_the_next(
    files: Path, place: str, after: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    back_up(place, files, capsys, "--recordings")
    new = tmp_path / "new"
    code = f"""
import os, signal
from storage.backup import files, reading
pages = reading.Archive.pages
def kill(*_):
    os.kill(os.getpid(), signal.SIGKILL)
def killed(self, kind):
    for page in pages(self, kind):
        yield page
        if kind == {after!r}:
            kill()
reading.Archive.pages = killed
if {after!r} == "files":
    files.os.utime = kill  # a file is complete, and not in its place yet
from robots.cli import main
main.main(["restore", {place!r}, "--data", {str(new)!r}])
"""
    done = subprocess.run([sys.executable, "-c", code], check=False, timeout=120)
    assert done.returncode == -signal.SIGKILL
    assert main.main(["restore", place, "--data", str(new)]) == 0
    for store in ("sqlite://{}/ppaas.sqlite", "file://{}/maps"):
        assert main.main(["store", "check", store.format(files), store.format(new)]) == 0
    assert files_in(new) == RECORDED
