"""Node logs: changes of the logs of nodes, which are stored with checkpoints, and their restoration."""

from collections.abc import Iterator

from engine.container.machine_client import MachineClient
from engine.container.monitor.leased_logs import LeasedLogs
from ppaas.change_log import LogChange, LogEntry
from ppaas.nodes.graph import Graph
from storage.records import CloneLogChange

MOST_BYTES = 16 << 20
"""Size of the entries that are sent to the machine at once, about [bytes]."""


class NodeLogs:
    """Logs of the nodes of a graph. A change that could not be stored is stored with the next checkpoint.

    Parameters
    ----------
    graph : Graph
    leased : LeasedLogs, optional
        Logs of the nodes that the robot runs.
    """

    def __init__(self, graph: Graph, leased: LeasedLogs | None = None) -> None:
        self._graph, self._leased = graph, leased or LeasedLogs()
        self._pending: dict[str, LogChange] = {}

    async def save(self, machine: MachineClient, checkpoint: dict[str, bytes]) -> None:
        """Store a checkpoint with the changes of all logs; entries of more than `MOST_BYTES` one part after another.

        Raises
        ------
        Unavailable
            The machine or its store does not answer in time; try again.
        """
        for name, change in self._changes():
            before = self._pending.get(name)
            self._pending[name] = change if before is None else before.then(change)
        pending = dict(self._pending)
        changes = [part for name, change in pending.items() for part in _parts(name, change)]
        for part in changes[:-1]:
            await machine.save_clone(checkpoint, [part])
        await machine.save_clone(checkpoint, changes[-1:])
        for name, change in pending.items():
            if self._pending.get(name) is change:
                del self._pending[name]

    def _changes(self) -> Iterator[tuple[str, LogChange]]:
        """Yield the changes since the last call: changes of leases first, which end before their node runs here."""
        yield from self._leased.take_changes().items()
        for node in self._graph.nodes_with_logs:
            change = node.log_change()
            if change is not None:
                yield node.name, change

    async def restore(self, machine: MachineClient) -> None:
        """Give each node its log, which it may read in a job.

        Raises
        ------
        Unavailable
            The machine or its store does not answer in time.
        """
        for name in self._leased.nodes:
            self._leased.load(name, [LogEntry(*entry) for entry in await machine.log(name)])
        for node in self._graph.nodes_with_logs:
            entries = [LogEntry(*entry) for entry in await machine.log(node.name)]
            if entries:
                node.restore_log(entries)


def _parts(node: str, change: LogChange) -> list[CloneLogChange]:
    """Return a change in parts; the last one removes what is obsolete."""
    parts: list[dict[int, bytes]] = [{}]
    size = 0
    for number, data in change.entries:
        if size + len(data) > MOST_BYTES and parts[-1]:
            parts.append({})
            size = 0
        parts[-1][number] = data
        size += len(data)
    return [*(CloneLogChange(node, part) for part in parts[:-1]), CloneLogChange(node, parts[-1], change.obsolete)]
