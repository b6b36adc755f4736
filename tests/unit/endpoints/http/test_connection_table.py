"""Connections are limited in all and per address, those that wait make room, and reaching a limit is logged once."""

import logging
import resource
from collections.abc import Iterator

import pytest
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from endpoints.http.connection_table import (
    MAX_FILES,
    ConnectionTable,
    address_key,
    connection_table,
    default_limit,
    raise_file_limit,
)


class Connection:
    """Connection that notes whether it had to make room."""

    closed = False

    def make_room(self) -> None:
        self.closed = True


def admitted(table: ConnectionTable, host: str, count: int) -> list[Connection]:
    connections = [Connection() for _ in range(count)]
    assert all(table.admit(connection, host) for connection in connections)
    return connections


def test_the_connection_that_has_waited_longest_makes_room() -> None:
    table = ConnectionTable(3, 3)
    first, second, third = admitted(table, "a", 3)
    table.serve(first)
    assert table.admit(Connection(), "b")
    assert [first.closed, second.closed, third.closed] == [False, True, False]
    table.wait(first)
    assert table.admit(Connection(), "b")
    assert [first.closed, third.closed] == [False, True]
    assert len(table) == 3


def test_connections_with_a_request_are_kept_and_new_ones_refused() -> None:
    table = ConnectionTable(3, 2)
    busy = admitted(table, "a", 2)
    for connection in busy:
        table.serve(connection)
    assert not table.admit(Connection(), "a")
    [other] = admitted(table, "b", 1)
    table.serve(other)
    assert not table.admit(Connection(), "c")
    table.leave(busy[0])
    assert table.admit(Connection(), "a")


def test_one_address_may_take_half_of_all_connections() -> None:
    table = ConnectionTable(10)
    for connection in admitted(table, "a", 5):
        table.serve(connection)
    assert not table.admit(Connection(), "a")
    admitted(table, "b", 5)


def test_a_limit_is_logged_once_until_there_are_fewer(caplog: pytest.LogCaptureFixture) -> None:
    table = ConnectionTable(20, 20)
    with caplog.at_level(logging.WARNING):
        connections = admitted(table, "a", 20)
        for connection in connections:
            table.serve(connection)
        for _ in range(5):
            assert not table.admit(Connection(), "b")
        assert len(caplog.records) == 1
        assert "--max-connections" in caplog.text
        for connection in connections[:5]:
            table.leave(connection)
        for connection in admitted(table, "b", 5):
            table.serve(connection)
        assert not table.admit(Connection(), "b")
    assert len(caplog.records) == 2


def test_an_ipv6_network_counts_as_one_address() -> None:
    assert address_key("192.0.2.7") == "192.0.2.7"
    assert address_key("::ffff:192.0.2.7") == "192.0.2.7"
    assert address_key("2001:db8:1:2::1") == address_key("2001:db8:1:2:ffff::9") == "2001:db8:1:2::/64"
    assert address_key("2001:db8:1:3::1") != address_key("2001:db8:1:2::1")
    assert address_key("fe80::1%eth0") == "fe80::/64"
    assert address_key("no:address") == "no:address"


def test_the_default_limit_leaves_files_for_everything_else() -> None:
    assert default_limit(1 << 20) == 10_000
    assert default_limit(1024) == 384
    assert default_limit(256) == 96
    assert default_limit(4) == 1


class Connections(RuleBasedStateMachine):
    """A table after any events has what a list has."""

    def __init__(self) -> None:
        super().__init__()
        self.table = ConnectionTable(6, 4)
        self.open: list[tuple[Connection, str]] = []
        self.waiting: list[Connection] = []

    @rule(host=st.sampled_from("abc"))
    def connect(self, host: str) -> None:
        connection = Connection()
        refused = self.is_full(4, [other for other, its in self.open if its == host])
        refused = refused or self.is_full(6, [other for other, _ in self.open])
        assert self.table.admit(connection, host) != refused
        if not refused:
            self.open.append((connection, host))
            self.waiting.append(connection)

    def is_full(self, limit: int, connections: list[Connection]) -> bool:
        if len(connections) < limit:
            return False
        victim = next((other for other in self.waiting if other in connections), None)
        if victim is not None:
            self.forget(victim)
        return victim is None

    def forget(self, connection: Connection) -> None:
        self.open = [pair for pair in self.open if pair[0] is not connection]
        self.waiting = [other for other in self.waiting if other is not connection]

    @rule(data=st.data(), event=st.sampled_from(["serve", "wait", "leave"]))
    def change(self, data: st.DataObject, event: str) -> None:
        if not self.open:
            return
        connection, _ = data.draw(st.sampled_from(self.open))
        getattr(self.table, event)(connection)
        if event == "leave":
            self.forget(connection)
        elif event == "serve":
            self.waiting = [other for other in self.waiting if other is not connection]
        elif connection not in self.waiting:
            self.waiting.append(connection)

    @invariant()
    def agrees(self) -> None:
        assert len(self.table) == len(self.open) <= 6
        assert not any(connection.closed for connection, _ in self.open)


TestConnections = Connections.TestCase


class IdleConnection:
    """IdleConnection that serves a request."""

    def make_room(self) -> None:
        raise AssertionError("it serves a request")


@pytest.fixture
def soft_limit() -> Iterator[int]:
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (512, hard))
    yield hard
    resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


# The limit of open files is raised to its hard limit, and bounds the connections.


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


def admitted_by(files: int, most: int | None, host: str | None = None) -> int:
    """Return the number of connections that a table admits, all from this host or each from its own."""
    table = connection_table(files, most, None)
    count = 0
    for number in range(1000):
        connection = IdleConnection()
        if not table.admit(connection, host or f"10.0.{number // 250}.{number % 250}"):
            break
        table.serve(connection)
        count += 1
    return count


def test_connections_are_limited_by_open_files_and_by_the_administrator(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.INFO):
        assert admitted_by(256, None) == 96
        assert "up to 96 connections" in caplog.text
        assert admitted_by(1 << 20, 7) == 7
        assert admitted_by(256, 500) == 96
        assert "raise ulimit -n" in caplog.text
    assert admitted_by(256, None, "10.1.1.1") == 48


def test_other_limits_hold_for_new_connections() -> None:
    table = ConnectionTable(4, 4)
    for connection in admitted(table, "a", 3):
        table.serve(connection)
    table.limit(3, 2)
    assert not table.admit(Connection(), "a") and not table.admit(Connection(), "b")
    assert len(table) == 3, "those that are open stay"
    table.limit(8, None)
    table.serve(*admitted(table, "a", 1))
    assert not table.admit(Connection(), "a"), "half of all are for one address"
    assert table.admit(Connection(), "b")
