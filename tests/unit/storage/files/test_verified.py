"""Damaged files of maps are detected."""

import hashlib
from pathlib import Path

import pytest

from ppaas.errors import Unavailable
from storage.files.store import FileMapStore
from tests.support.storage.records import found_map, house, pgm, put_map

OLD = house(image=pgm(value=0))


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
