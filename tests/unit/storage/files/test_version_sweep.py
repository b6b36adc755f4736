"""Removal of versions from the log of a map: interrupted, repeated, and while the same files are published."""

import json
from pathlib import Path

import pytest

from storage.files.store import FileMapStore, LocalDisk
from storage.files.version_sweep import VersionSweep
from tests.support.storage.records import found_map, house, pgm, put_map

FIRST, SECOND = house(image=pgm(value=0)), house(image=pgm(value=254))


@pytest.fixture
def maps(tmp_path: Path) -> FileMapStore:
    store = FileMapStore(tmp_path)
    for one in (FIRST, SECOND):
        put_map(store, one)
    return store


def files(folder: Path) -> list[str]:
    return sorted(path.name for path in (folder / "house" / "files-1").iterdir())


def entries(folder: Path) -> list[int]:
    return sorted(int(path.name) for path in (folder / "house" / "log").iterdir())


def test_only_files_that_no_other_version_has_are_deleted(maps: FileMapStore, tmp_path: Path) -> None:
    assert len(files(tmp_path)) == 3
    maps.remove_versions("house", [FIRST.version])
    assert len(files(tmp_path)) == 2
    assert entries(tmp_path) == [2, 3]


def test_an_interrupted_removal_is_finished_by_the_next_one(
    maps: FileMapStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def killed(*_: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(VersionSweep, "run", killed)
        with pytest.raises(KeyboardInterrupt):
            maps.remove_versions("house", [FIRST.version])
    assert [one.version for one in maps.versions("house")] == [SECOND.version]
    maps.change_map("house", description="in between")
    assert [one.version for one in maps.versions("house")] == [SECOND.version]
    maps.remove_versions("house", [])
    assert entries(tmp_path) == [2, 3, 4, 5]
    assert len(files(tmp_path)) == 2


def test_a_file_that_is_published_while_it_is_removed_is_kept(
    maps: FileMapStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    move = LocalDisk.move
    published: list[str] = []

    def publish_first(disk: LocalDisk, source: str, target: str) -> bool:
        if not published:
            published.append(put_map(FileMapStore(tmp_path), FIRST).version)
        return move(disk, source, target)

    monkeypatch.setattr(LocalDisk, "move", publish_first)
    maps.remove_versions("house", [FIRST.version])
    assert published == [FIRST.version]
    assert found_map(maps) == FIRST
    assert not any(name.startswith(".removed") for name in files(tmp_path))


def test_a_writer_places_a_file_again_that_was_moved_before_its_entry_was_created(
    maps: FileMapStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    create = LocalDisk.create
    removed: list[str] = []

    def remove_first(disk: LocalDisk, path: str, data: bytes) -> bool:
        if not removed:
            removed.append(FIRST.version)
            FileMapStore(tmp_path).remove_versions("house", [FIRST.version])
        return create(disk, path, data)

    monkeypatch.setattr(LocalDisk, "create", remove_first)
    put_map(maps, FIRST)
    assert found_map(maps) == FIRST


def test_a_log_of_an_earlier_release_has_no_removals(maps: FileMapStore, tmp_path: Path) -> None:
    last = tmp_path / "house" / "log" / "00000002"
    old = json.loads(last.read_bytes())
    del old["removed"], old["crc"]
    last.write_text(json.dumps(old))
    maps.remove_versions("house", [FIRST.version])
    assert [one.version for one in maps.versions("house")] == [SECOND.version]
