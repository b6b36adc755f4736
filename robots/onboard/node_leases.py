"""Leases of the nodes that run on the robot, with the last known state of each node."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import msgspec

from ppaas.change_log import LogChange, LogEntry
from ppaas.messages.ppaas_msgs import HoldNodeResponse, TopicMessage
from robots.onboard.executor import protocol
from robots.onboard.node_monitor_client import NodeMonitorClient, NodeSnapshot


@dataclass(slots=True)
class NodeLease:
    """Lease of a node.

    Parameters
    ----------
    number : int
        Number that the node monitor has given it.
    snapshot : NodeSnapshot
        Last known state of the node.
    synchronized : bool
        Whether it was renewed, so that the messages that arrived during the move of the node are known.
    """

    number: int
    snapshot: NodeSnapshot
    synchronized: bool = False


def log_change(state: protocol.NodeReport | protocol.Removed) -> LogChange:
    """Return the change of the log in a state of a node."""
    return LogChange([LogEntry(*row) for row in state.log], list(state.obsolete))


class NodeLeases:
    """Takes leases from the node monitor, renews them, and gives them back.

    Parameters
    ----------
    monitor : NodeMonitorClient
        Client of the node monitor.
    """

    def __init__(self, monitor: NodeMonitorClient) -> None:
        self._monitor = monitor
        self._held: dict[str, NodeLease] = {}
        self._lost: dict[str, tuple[NodeLease, str]] = {}

    def __contains__(self, node: object) -> bool:
        return node in self._held

    def nodes(self) -> tuple[str, ...]:
        """Return the names of the nodes that are leased."""
        return tuple(self._held)

    def synchronized(self) -> frozenset[str]:
        """Return the names of the nodes whose lease was renewed at least once."""
        return frozenset(node for node, lease in self._held.items() if lease.synchronized)

    async def take(self, node: str) -> HoldNodeResponse:
        """Lease a node; return its checkpoint and its log.

        Raises
        ------
        Unavailable
            The node monitor is unreachable, or the wanted home of the node is the cloud.
        """
        taken = await self._monitor.take_node(node)
        self._held[node] = NodeLease(taken.lease, NodeSnapshot(taken.state))
        return taken

    async def refuse(self, node: str, failure: str) -> None:
        """Report why a node cannot run here, before it was leased."""
        await self._monitor.give_node(node, 0, failure=failure)

    def collect(self, states: Mapping[str, protocol.NodeReport]) -> dict[str, protocol.NodeReport]:
        """Note the changes of the logs in states, and return the states without them.

        The executor reports a change once, so the changes of all nodes are noted before a renewal may fail.
        """
        for node, state in states.items():
            if node in self._held:
                lease = self._held[node]
                lease.snapshot = replace(lease.snapshot, log=lease.snapshot.log.then(log_change(state)))
        return {node: msgspec.structs.replace(state, log=[], obsolete=[]) for node, state in states.items()}

    async def renew(
        self, node: str, state: protocol.NodeReport | None, heard: list[str]
    ) -> Sequence[TopicMessage] | None:
        """Renew the lease of a node.

        Parameters
        ----------
        node : str
            Name of the node.
        state : NodeReport, optional
            Its state; None repeats the last one.
        heard : list of str
            Fingerprints of the guaranteed messages that it had received by then.

        Returns
        -------
        sequence of TopicMessage, optional
            Messages that arrived for the node in the cloud; None if the node monitor no longer knows the lease.
        """
        lease = self._held[node]
        current = state or protocol.NodeReport(lease.snapshot.state)
        change = lease.snapshot.log.then(log_change(current))
        lease.snapshot = NodeSnapshot(current.state, heard, change)
        current = msgspec.structs.replace(
            current, log=[(number, data) for number, data in change.entries], obsolete=change.obsolete
        )
        answer = await self._monitor.hold_node(node, lease.number, current, heard)
        if answer.lease != lease.number:
            return None
        lease.snapshot = NodeSnapshot(current.state, heard)  # the change of the log has arrived
        lease.synchronized = True
        return answer.unheard

    def note(self, node: str, snapshot: NodeSnapshot) -> None:
        """Set the last known state of a leased node, with the change of its log since the last."""
        lease = self._held[node]
        lease.snapshot = replace(snapshot, log=lease.snapshot.log.then(snapshot.log))

    def drop(self, node: str) -> NodeLease:
        """End a lease without a notice to the node monitor; return it."""
        return self._held.pop(node)

    async def give_back(self, node: str, lease: NodeLease) -> None:
        """Return a dropped lease to the node monitor, with the last known state of the node."""
        await self._monitor.give_node(node, lease.number, lease.snapshot)

    def lose(self, failure: str) -> tuple[str, ...]:
        """End all leases because of a failure, which ``report_lost`` reports; return the names of the nodes."""
        lost, self._held = self._held, {}
        self._lost |= {node: (lease, failure) for node, lease in lost.items()}
        return tuple(lost)

    async def report_lost(self) -> None:
        """Report the lost nodes to the node monitor; those that cannot be reported now stay for the next call."""
        for node, (lease, failure) in tuple(self._lost.items()):
            await self._monitor.give_node(node, lease.number, lease.snapshot, failure)
            del self._lost[node]
