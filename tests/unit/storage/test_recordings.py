"""Folder of recordings: what it lists, and what it removes."""

from pathlib import Path

import pytest

from ppaas.errors import InvalidInput, NotFound
from storage.recordings import RecordingsFolder, is_recording_id


@pytest.fixture
def folder(tmp_path: Path) -> RecordingsFolder:
    robot = tmp_path / "ann" / "tb1"
    (robot / "ring").mkdir(parents=True)
    for name in ("20261126T224142Z.mcap", "20261126T224143Z-2.partial", "notes.txt", "x.mcap"):
        (robot / name).write_bytes(b"1234")
    for name in ("0000000000000000020.mcap", "0000000000000000003.mcap", "odd.mcap"):
        (robot / "ring" / name).write_bytes(b"12")
    return RecordingsFolder(tmp_path)


def test_recordings_are_listed_newest_first(folder: RecordingsFolder) -> None:
    found = folder.recordings("ann", "tb1")
    assert [(one.id, one.size, one.finished) for one in found] == [
        ("20261126T224143Z-2", 4, False),
        ("20261126T224142Z", 4, True),
    ]
    assert folder.recordings("ann", "tb2") == []


def test_segments_are_listed_oldest_first(folder: RecordingsFolder) -> None:
    assert [segment.begin for segment in folder.segments("ann", "tb1")] == [3, 20]
    assert folder.size("ann") == 4 * 4 + 3 * 2


@pytest.mark.parametrize("id", ["ring", "x", "../tb1", "20261126T224199Z", "20261126T224142Z/../x", ""])
def test_other_ids_are_unknown(folder: RecordingsFolder, id: str) -> None:  # noqa: A002
    with pytest.raises(NotFound, match="recording"):
        folder.recording("ann", "tb1", id)


def test_names_cannot_leave_the_folder(folder: RecordingsFolder) -> None:
    with pytest.raises(InvalidInput):
        folder.recordings("..", "tb1")
    assert not is_recording_id("20261126T224142Z\n")


def test_removal(folder: RecordingsFolder) -> None:
    folder.remove_recording("ann", "tb1", "20261126T224142Z")
    with pytest.raises(NotFound):
        folder.remove_recording("ann", "tb1", "20261126T224142Z")
    folder.remove_ring("ann", "tb1")
    assert folder.segments("ann", "tb1") == []
    folder.remove_robot("ann", "tb1")
    folder.remove_robot("ann", "tb1")
    folder.remove_user("ann")
    assert not (folder.path / "ann").exists()
