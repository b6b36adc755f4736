"""The limit of open files is raised to its hard limit, and bounds the connections."""

import logging
import resource
from collections.abc import Iterator

import pytest

from endpoints.http.open_files import MAX_FILES, connection_table, raise_file_limit


class Connection:
    """Connection that serves a request."""

    def make_room(self) -> None:
        raise AssertionError("it serves a request")


@pytest.fixture
def soft_limit() -> Iterator[int]:
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (512, hard))
    yield hard
    resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def test_the_limit_of_open_files_is_raised_to_its_hard_limit(soft_limit: int) -> None:
    highest = MAX_FILES if soft_limit == resource.RLIM_INFINITY else min(soft_limit, MAX_FILES)
    assert raise_file_limit() == highest == resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    assert raise_file_limit() == highest


def test_a_limit_that_cannot_be_raised_is_kept_and_logged(
    soft_limit: int, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def refuse(*_arguments: object) -> None:
        raise ValueError("not allowed")

    monkeypatch.setattr(resource, "setrlimit", refuse)
    assert raise_file_limit() == 512
    assert "not allowed" in caplog.text
    monkeypatch.undo()
    assert soft_limit > 512


def admitted(files: int, most: int | None, host: str | None = None) -> int:
    """Return the number of connections that a table admits, all from this host or each from its own."""
    table = connection_table(files, most, None)
    count = 0
    for number in range(1000):
        connection = Connection()
        if not table.admit(connection, host or f"10.0.{number // 250}.{number % 250}"):
            break
        table.serve(connection)
        count += 1
    return count


def test_connections_are_limited_by_open_files_and_by_the_administrator(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.INFO):
        assert admitted(256, None) == 96
        assert "up to 96 connections" in caplog.text
        assert admitted(1 << 20, 7) == 7
        assert admitted(256, 500) == 96
        assert "raise ulimit -n" in caplog.text
    assert admitted(256, None, "10.1.1.1") == 48
