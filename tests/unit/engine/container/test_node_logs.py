"""Node logs: changes of nodes here, and of those that the robot runs, are stored in order."""

from collections.abc import Sequence
from typing import Any

import pytest

from engine.container.monitor.leased_logs import LeasedLogs
from engine.container.node_logs import NodeLogs
from ppaas.change_log import LogChange, LogEntry
from ppaas.errors import Unavailable
from ppaas.nodes.base import Node
from ppaas.nodes.graph import Graph


class Mapper(Node):
    """Node with a log."""

    name = "mapper"
    keeps_log = True

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        self.changes: list[LogChange] = []
        self.restored: list[LogEntry] = []

    def log_change(self) -> LogChange | None:
        return self.changes.pop(0) if self.changes else None

    def restore_log(self, entries: Sequence[LogEntry]) -> None:
        self.restored = list(entries)


class FakeMachine:
    """Machine that stores logs."""

    def __init__(self) -> None:
        self.logs: dict[str, dict[int, bytes]] = {}
        self.away = False

    async def save_clone(self, _nodes: dict[str, bytes], changes: Sequence[Any] = ()) -> None:
        if self.away:
            raise Unavailable("the store is away")
        for change in changes:
            log = self.logs.setdefault(change.log, {})
            log.update(change.entries)
            for number in change.obsolete:
                log.pop(number, None)

    async def log(self, node: str) -> list[tuple[int, bytes]]:
        return sorted(self.logs.get(node, {}).items())


def change(*entries: tuple[int, bytes], obsolete: Sequence[int] = ()) -> LogChange:
    return LogChange([LogEntry(*entry) for entry in entries], list(obsolete))


@pytest.fixture
def machine() -> Any:
    return FakeMachine()


async def test_the_log_of_a_node_is_stored_wherever_it_runs(machine: Any) -> None:
    graph, leased = Graph(), LeasedLogs()
    node = graph.add(Mapper)
    logs = NodeLogs(graph, leased)
    node.changes.append(change((0, b"a")))
    await logs.save(machine, {})
    leased.begin("mapper", change((1, b"a"), (2, b"b"), obsolete=[0]))
    graph.remove("mapper")
    machine.away = True
    with pytest.raises(Unavailable):
        await logs.save(machine, {})
    leased.change("mapper", change((3, b"c"), obsolete=[1]))
    machine.away = False
    await logs.save(machine, {})
    assert machine.logs == {"mapper": {2: b"b", 3: b"c"}}

    leased.change("mapper", change((4, b"d")))
    leased.end("mapper")
    node = graph.add(Mapper)
    node.changes.append(change((5, b"e"), obsolete=[4]))
    await logs.save(machine, {})
    assert machine.logs == {"mapper": {2: b"b", 3: b"c", 5: b"e"}}


async def test_logs_are_restored_wherever_their_nodes_run(machine: Any) -> None:
    machine.logs = {"mapper": {0: b"a"}, "another": {7: b"b"}}
    graph, leased = Graph(), LeasedLogs()
    node = graph.add(Mapper)
    leased.load("another", ())
    await NodeLogs(graph, leased).restore(machine)
    assert node.restored == [LogEntry(0, b"a")]
    assert leased.of("another") == [LogEntry(7, b"b")]
    assert leased.take_changes() == {}
