"""What a backup reads: the file of an SQLite store is copied first, wherever its URL says that it is."""

from pathlib import Path

import pytest

from storage.backup.sources import existing
from storage.sqlite.store import SqliteStore
from tests.support.storage.records import user


@pytest.mark.parametrize("url", ["sqlite:stores/ppaas.sqlite", "sqlite://{here}/stores/ppaas.sqlite"])
def test_a_store_is_read_from_a_copy_by_relative_and_absolute_urls(
    url: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "stores").mkdir()
    store = SqliteStore(tmp_path / "stores" / "ppaas.sqlite")
    store.add_user(user("ann"))
    store.close()
    with existing(url.format(here=tmp_path), None) as sources:
        assert sources.store is not None and sources.store.user("ann").id == "ann"
    assert [file.name for file in (tmp_path / "stores").iterdir() if file.is_dir()] == []
