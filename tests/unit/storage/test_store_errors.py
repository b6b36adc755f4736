"""Errors of stores name the file or the address to operators, but not to clients.

The kind: a text that tells strangers how a server is built. Its members: files of the stores and of drafts, addresses
of Cassandra and HDFS, shared memory of layers and indexes, each by REST, in frames of rosbridge, and over the links
between processes, whose texts end up there.
"""

import errno
import logging
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from engine.protocols.refusals import refusal_of
from engine.specs.layer_files import open_layers, write_index
from ppaas.errors import NotFound, Unavailable, rebuild
from storage.sqlite.connections import _Errors
from storage.sqlite.store import SqliteStore
from storage.store_errors import _ADVICE, NO_STORE, disk_errors, unusable


def told(error: Unavailable, secret: object) -> str:
    """Return the text for clients; the text for operators has the secret."""
    assert str(secret) in str(error)
    assert str(secret) not in error.public
    assert error.public
    return error.public


def test_a_place_is_for_operators() -> None:
    assert told(unusable("/srv/x.sqlite", "restore it"), "/srv") == NO_STORE
    assert told(unusable("/srv/x.sqlite", "it is full", "it is full"), "/srv") == "it is full"


@pytest.mark.parametrize("number", [*_ADVICE, errno.ENXIO])
def test_errors_of_the_disk_do_not_name_the_file_to_clients(tmp_path: Path, number: int) -> None:
    with pytest.raises(Unavailable) as caught, disk_errors(tmp_path):
        raise OSError(number, "why", str(tmp_path / "file"))
    told(caught.value, tmp_path)


@pytest.mark.parametrize("code", [sqlite3.SQLITE_FULL, sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_MISUSE])
def test_errors_of_sqlite_do_not_name_the_file_to_clients(tmp_path: Path, code: int) -> None:
    failed = sqlite3.OperationalError(f"no table in {tmp_path}")
    failed.sqlite_errorcode = code
    with pytest.raises(Unavailable) as caught, _Errors(tmp_path):
        raise failed
    told(caught.value, tmp_path)


def test_a_damaged_file_is_not_named_to_clients(tmp_path: Path) -> None:
    path = tmp_path / "x.sqlite"
    path.write_bytes(b"no database" * 1000)
    with pytest.raises(Unavailable) as caught, closing(SqliteStore(path)):
        pass
    assert told(caught.value, path) == NO_STORE


def test_shared_memory_is_not_named_to_clients(tmp_path: Path) -> None:
    with pytest.raises(Unavailable) as caught:
        open_layers(tmp_path / "missing")
    told(caught.value, tmp_path)
    with pytest.raises(Unavailable) as caught:
        write_index(tmp_path / "missing", "hub_labels", memoryview(b"index"))
    told(caught.value, tmp_path)


def test_a_refusal_carries_the_text_for_clients_and_logs_the_other(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        refusal = refusal_of(unusable("/srv/x.sqlite", "restore it"))
        assert refusal_of(NotFound("map", "house")).text == "unknown map 'house'"
    assert "/srv" not in refusal.text
    assert [record.getMessage() for record in caplog.records] == ["unavailable: /srv/x.sqlite: restore it"]
    again = rebuild(refusal.slug, refusal.text)
    assert isinstance(again, Unavailable)
    assert again.public == str(again) == NO_STORE
