"""The log of a map on a disk."""

from pathlib import Path

import pytest

from ppaas.errors import NotFound, Unavailable
from storage.files.store import FileMapStore
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
