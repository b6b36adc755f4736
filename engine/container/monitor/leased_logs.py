"""Logs of the nodes that the robot runs: they follow the changes that the robot reports with its leases."""

from collections.abc import Iterable, Sequence

from ppaas.change_log import LogChange, LogEntry
from ppaas.messages.ppaas_msgs import LogPart

MOST_BYTES = 24 << 20
"""Size of a log above which its node is not moved [bytes]; a message to a robot has at most 64 MiB, with base64."""


class LeasedLogs:
    """Logs of nodes, by their names. Changes are also kept until they are taken, to be stored."""

    def __init__(self) -> None:
        self._entries: dict[str, dict[int, bytes]] = {}
        self._pending: dict[str, LogChange] = {}

    @property
    def nodes(self) -> tuple[str, ...]:
        """Names of the nodes."""
        return tuple(self._entries)

    def begin(self, node: str, change: LogChange | None) -> None:
        """Begin the log of a node that moves to the robot, with all its entries."""
        self._entries[node] = {}
        if change is not None:
            self.change(node, change)

    def load(self, node: str, entries: Iterable[LogEntry]) -> None:
        """Continue the log of a node that the robot runs, after the process of the clone was replaced."""
        self._entries[node] = dict(entries) | self._entries.get(node, {})

    def change(self, node: str, change: LogChange) -> None:
        """Apply a change, unless the node does not run on the robot any more."""
        if node not in self._entries or not (change.entries or change.obsolete):
            return
        log = self._entries[node]
        log.update(change.entries)
        for number in change.obsolete:
            log.pop(number, None)
        before = self._pending.get(node)
        self._pending[node] = change if before is None else before.then(change)

    def of(self, node: str) -> list[LogEntry]:
        """Return the log of a node, sorted by number."""
        return [LogEntry(*entry) for entry in sorted(self._entries.get(node, {}).items())]

    def size(self, node: str) -> int:
        """Return the size of the log of a node [bytes]."""
        return sum(map(len, self._entries.get(node, {}).values()))

    def end(self, node: str) -> list[LogEntry]:
        """Return the log of a node that runs in the cloud again, and forget it; its last changes are still taken."""
        entries = self.of(node)
        self._entries.pop(node, None)
        return entries

    def take_changes(self) -> dict[str, LogChange]:
        """Return the changes since the last call, by node."""
        changes, self._pending = self._pending, {}
        return changes


def change_of(parts: Sequence[LogPart], obsolete: Sequence[int]) -> LogChange:
    """Return the change in a message of the robot."""
    return LogChange([LogEntry(part.number, part.data) for part in parts], list(obsolete))


def parts_of(entries: Iterable[LogEntry]) -> list[LogPart]:
    """Return entries for a message to the robot."""
    return [LogPart(*entry) for entry in entries]
