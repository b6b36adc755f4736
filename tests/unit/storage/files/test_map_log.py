"""The log of a map on a disk."""

import hashlib
from pathlib import Path

import msgspec
import pytest

from ppaas.errors import NotFound, Unavailable
from storage.files.log_entries import MapLogEntry, decode_entry, encode_entry
from storage.files.store import FileMapStore
from storage.records import ProposedChange
from tests.support.storage.records import found_map, house, pgm, put_map

OLD = house(image=pgm(value=0))


@pytest.mark.parametrize("head", [b"{", b"", b'{"era": "one"}'])
def test_a_damaged_entry_is_reported(tmp_path: Path, head: bytes) -> None:
    store = FileMapStore(tmp_path)
    put_map(store, OLD)
    (tmp_path / "house" / "log" / "00000001").write_bytes(head)
    with pytest.raises(Unavailable, match=r"house/log/00000001.*backup"):
        found_map(store)


def test_a_stray_file_in_the_folder_is_not_a_map(tmp_path: Path) -> None:
    store = FileMapStore(tmp_path)
    (tmp_path / "README").write_text("maps of the building")
    assert store.maps() == []
    with pytest.raises(NotFound):
        store.map_head("README")
    with pytest.raises(Unavailable, match="file is where a folder should be"):
        put_map(store, house("README"))


ENTRY = MapLogEntry(3, "ann", ("bob",), "a house", removed=(1, 2))


# Entries of a map's log have a checksum; a damaged one makes its own map unusable, and no other.


def test_an_entry_is_read_as_written() -> None:
    assert decode_entry(encode_entry(ENTRY), "house/log/1") == ENTRY


def test_an_entry_of_an_earlier_release_without_a_checksum_is_read() -> None:
    assert decode_entry(msgspec.json.encode(ENTRY), "house/log/1") == ENTRY


def test_an_earlier_release_reads_an_entry_with_a_checksum() -> None:
    assert msgspec.json.decode(encode_entry(ENTRY), type=MapLogEntry) == ENTRY


def test_a_review_of_an_earlier_release_names_no_places_of_a_robot() -> None:
    review = b'{"number":2,"version":"b","base":"a","created":0.0,"author":"ann","change":{"free":3}}'
    entry = decode_entry(b'{"era":1,"reviews":[' + review + b"]}", "house/log/1")
    assert entry.reviews[0].change == ProposedChange(free=3, confirmed=None)


def test_any_changed_byte_after_the_name_of_the_checksum_is_noticed() -> None:
    data = encode_entry(ENTRY)
    for index in range(len(b'{"crc":"'), len(data)):
        damaged = data[:index] + bytes([data[index] ^ 1]) + data[index + 1 :]
        with pytest.raises(Unavailable, match="house/log/1 is damaged"):
            decode_entry(damaged, "house/log/1")


def test_a_damaged_map_is_left_out_of_lists_and_named_once_in_the_log(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    store = FileMapStore(tmp_path)
    for map_id in ("cellar", "house", "shed"):
        put_map(store, house(map_id=map_id))
    entry = tmp_path / "house" / "log" / "00000001"
    entry.write_bytes(entry.read_bytes().replace(b'"ann"', b'"eve"'))
    for _ in range(2):
        assert [head.id for head in store.maps()] == ["cellar", "shed"]
    assert [head.id for head in store.maps(limit=2)] == ["cellar", "shed"]
    (line,) = caplog.messages
    assert "map 'house' is left out of lists" in line and "its checksum differs" in line
    with pytest.raises(Unavailable, match="house/log/00000001 of the maps is damaged"):
        store.map_head("house")
    assert found_map(store, "shed").files == house().files


# Damaged files of maps are detected.


def test_damaged_files_are_reported_and_repaired_by_publishing_again(tmp_path: Path) -> None:
    store = FileMapStore(tmp_path)
    put_map(store, OLD)
    image = tmp_path / "house" / "files-1" / hashlib.sha256(OLD.image or b"").hexdigest()
    for damage in (lambda: image.write_bytes(b"P5"), image.unlink):
        damage()
        with pytest.raises(Unavailable, match="publish it again"):
            found_map(store)
        put_map(store, OLD)
        assert found_map(store) == OLD
