"""Connections are limited in all and per address, those that wait make room, and reaching a limit is logged once."""

import logging

import pytest
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from endpoints.http.connection_table import ConnectionTable, address_key, default_limit


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
