"""The map store in a folder beyond the contract of map stores: durability, sharing, and killed writers."""

import hashlib
import itertools
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from ppaas.errors import Conflict, NotFound, Unavailable
from storage.files import store as files
from storage.files.store import FileMapStore
from storage.records import Publication
from tests.support.storage.records import YAML, found_map, house, pgm, put_map

OLDEST, OLD, NEW, LAST = (house(image=pgm(value=value)) for value in (100, 0, 254, 205))


def names(folder: Path) -> set[str]:
    return {entry.name for entry in folder.iterdir()}


def test_a_reopened_folder_keeps_everything(tmp_path: Path) -> None:
    put_map(FileMapStore(tmp_path / "maps"), house(readers=("bob",)))
    assert found_map(FileMapStore(tmp_path / "maps")) == house(readers=("bob",))


def test_files_that_versions_share_are_stored_once(tmp_path: Path) -> None:
    store = FileMapStore(tmp_path)
    put_map(store, OLD)
    put_map(store, NEW)
    expected = {hashlib.sha256(data).hexdigest() for data in (*OLD.files.values(), *NEW.files.values())}
    assert names(tmp_path / "house" / "files-1") == expected
    assert len(expected) == 3
    assert names(tmp_path / "house" / "log") == {"00000001", "00000002"}


def test_no_temporary_files_are_left(tmp_path: Path) -> None:
    store = FileMapStore(tmp_path)
    put_map(store, OLD)
    put_map(store, NEW)
    store.remove_map("house")
    assert names(tmp_path) == {".incoming", ".lock", "house"}
    assert names(tmp_path / ".incoming") == set()
    assert names(tmp_path / "house") == {"log"}
    assert names(tmp_path / "house" / "log") == {"00000003"}  # the entry of the removal
    put_map(store, OLD)
    assert names(tmp_path / "house") == {"log", "files-4"}
    assert names(tmp_path / "house" / "log") == {"00000004"}


KILLED_AT = ("open", "os.link", "os.rename", "os.mkdir", "os.rmdir", "os.remove", "shutil.rmtree")


def killed_at(step: int, act: Callable[[], object]) -> int:
    """Run a function in a process that is killed before its nth disk operation."""
    child = os.fork()
    if child:
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    calls = itertools.count(1)

    def watch(event: str, _arguments: object) -> None:
        if event in KILLED_AT and next(calls) == step:
            os.kill(os.getpid(), signal.SIGKILL)

    status = 1
    try:
        sys.addaudithook(watch)
        act()
        status = 0
    finally:
        os._exit(status)


ACTIONS: dict[str, tuple[Callable[[FileMapStore], object], Any]] = {
    "publish": (lambda store: put_map(store, NEW), NEW),
    "roll back": (lambda store: store.roll_back(OLDEST.version, Publication("house", "ann", 3.0)), OLDEST),
    "remove": (lambda store: store.remove_map("house"), None),
}


@pytest.mark.parametrize("action", ACTIONS)
def test_a_kill_at_any_step_leaves_the_map_before_or_after(tmp_path: Path, action: str) -> None:
    act, after = ACTIONS[action]
    seen = []
    for step in range(1, 200):
        store = FileMapStore(tmp_path / str(step))
        put_map(store, OLDEST)
        put_map(store, OLD)
        status = killed_at(step, lambda store=store: act(store))
        seen.append(present(store))
        put_map(store, LAST)
        assert found_map(store) == LAST
        assert names(tmp_path / str(step) / ".incoming") == set()
        if status != -signal.SIGKILL:
            break
    assert status == 0
    turn = seen.index(after)
    assert turn > 0
    assert all(record == OLD for record in seen[:turn])
    assert all(record == after for record in seen[turn:])


def present(store: FileMapStore) -> object:
    try:
        return found_map(store)
    except NotFound:
        return None


def test_a_first_publication_that_was_killed_leaves_no_map(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store = FileMapStore(tmp_path)
    with monkeypatch.context() as patch:
        patch.setattr(FileMapStore, "_append", raising(KeyboardInterrupt()))
        with pytest.raises(KeyboardInterrupt):
            put_map(store, OLD)
    assert store.maps() == []
    with pytest.raises(NotFound):
        store.remove_map("house")
    put_map(store, house(owner="bob"))
    assert found_map(store).owner == "bob"


def raising(error: BaseException) -> Callable[..., None]:
    def fail(*_args: object, **_named: object) -> None:
        raise error

    return fail


@pytest.mark.parametrize(
    ("number", "text"), [(28, "disk is full"), (30, "read-only"), (13, "permission denied"), (5, "disk fails")]
)
def test_a_disk_that_fails_is_unavailable_and_the_map_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int, text: str
) -> None:
    store = FileMapStore(tmp_path)
    put_map(store, OLD)
    with monkeypatch.context() as patch:
        patch.setattr(files.os, "fsync", raising(OSError(number, os.strerror(number))))
        with pytest.raises(Unavailable, match=text):
            put_map(store, NEW)
    assert found_map(store) == OLD
    assert names(tmp_path / ".incoming") == set()


def test_readers_see_only_complete_maps_while_others_write(tmp_path: Path) -> None:
    store = FileMapStore(tmp_path)
    put_map(store, OLD)
    done = threading.Event()

    def write() -> None:
        try:
            for _ in range(15):
                put_map(store, NEW)
                store.remove_map("house")
                put_map(store, OLD)
        finally:
            done.set()

    def read() -> set[str]:
        seen = set()
        while not done.is_set():
            record = present(store)
            seen.add("gone" if record is None else "old" if record == OLD else "new" if record == NEW else "torn")
        return seen

    with ThreadPoolExecutor(3) as threads:
        readers = [threads.submit(read) for _ in range(2)]
        threads.submit(write).result()
    assert set().union(*(reader.result() for reader in readers)) <= {"old", "new", "gone"}
    assert found_map(store) == OLD


PUBLISHER = """
import sys
from pathlib import Path
from ppaas.errors import Conflict
from storage.files.store import FileMapStore
from tests.support.storage.records import house, put_map
try:
    put_map(FileMapStore(Path(sys.argv[1])), house(owner=sys.argv[2]))
except Conflict:
    sys.exit(3)
"""


def test_one_of_concurrent_processes_gets_a_new_map_id(tmp_path: Path) -> None:
    owners = ["ann", "bob", "carl"]
    publishers = [subprocess.Popen([sys.executable, "-c", PUBLISHER, str(tmp_path), owner]) for owner in owners]
    statuses = [publisher.wait() for publisher in publishers]
    assert sorted(statuses) == [0, 3, 3]
    assert FileMapStore(tmp_path).map_head("house").owner == owners[statuses.index(0)]


def test_a_file_in_place_of_the_folder_is_unavailable(tmp_path: Path) -> None:
    (tmp_path / "maps").write_text("")
    with pytest.raises(Unavailable, match="file is where a folder should be"):
        FileMapStore(tmp_path / "maps")


def test_an_owner_keeps_the_map_after_a_conflict(tmp_path: Path) -> None:
    store = FileMapStore(tmp_path)
    put_map(store, OLD)
    with pytest.raises(Conflict):
        put_map(store, house(owner="bob", image=pgm(value=9)))
    assert names(tmp_path / "house" / "log") == {"00000001"}
    assert names(tmp_path / "house" / "files-1") == {hashlib.sha256(data).hexdigest() for data in OLD.files.values()}


SIDE = 8192
MEMORY_LIMIT = 32 << 20
"""Memory limit of a process beyond its size after all imports [bytes]: half of the size of the map's image."""

LIMITED = """
import resource, sys
from pathlib import Path
import numpy as np
from endpoints.rest.maps.content_check import check_contents
from ppaas.maps.formats.difference import difference
from ppaas.maps.formats.map_files import open_grid
from storage.staged_uploads import BLOCK, blocks
from storage.files.store import FileMapStore
from storage.records import Publication

folder, most = Path(sys.argv[1]), int(sys.argv[2])
store = FileMapStore(folder / "maps")
taken = int(Path("/proc/self/status").read_text().split("VmData:")[1].split()[0]) * 1024
resource.setrlimit(resource.RLIMIT_DATA, (taken + most, taken + most))

def read(path):
    with path.open("rb") as file:
        while block := file.read(BLOCK):
            yield block

def publish(name):
    with store.stage() as upload:
        upload.add("yaml", read(folder / "map.yaml"))
        upload.add("image", read(folder / name))
        check_contents(upload)
        return store.publish(upload, Publication("large", "ann", 1.0)).version

if sys.argv[3] == "stream":
    old, new = publish("old.pgm"), publish("new.pgm")
    with store.open_map("large", old) as before, store.open_map("large", new) as after:
        size = sum(len(block) for block in blocks(after.buffer("image")))
        found = difference(open_grid(*before.grid()), open_grid(*after.grid()))
    print(size, found.changed, *found.rectangle)
else:
    (folder / "old.pgm").read_bytes()
"""


@pytest.fixture(scope="module")
def large(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with two images that differ in a square."""
    folder = tmp_path_factory.mktemp("large")
    (folder / "map.yaml").write_bytes(YAML)
    header = b"P5\n%d %d\n255\n" % (SIDE, SIDE)
    (folder / "old.pgm").write_bytes(header + b"\xfe" * SIDE * SIDE)
    with (folder / "new.pgm").open("wb") as file:
        file.write(header + b"\xfe" * SIDE * SIDE)
        for row in range(100, 110):
            file.seek(len(header) + row * SIDE + 200)
            file.write(bytes(10))
    return folder


def limited(folder: Path, what: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", LIMITED, str(folder), str(MEMORY_LIMIT), what]
    return subprocess.run(command, capture_output=True, text=True, check=False)


# Maps of 8192 × 8192 cells are published and read with a fraction of their size in memory.


def test_a_map_is_published_read_and_compared_within_half_its_size(large: Path) -> None:
    ended = limited(large, "stream")
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.split() == [str(SIDE * SIDE + 17), "100", "200", str(SIDE - 110), "10", "10"]


def test_reading_the_whole_map_exceeds_the_limit(large: Path) -> None:
    assert "MemoryError" in limited(large, "whole").stderr
