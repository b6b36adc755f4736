"""Interfaces of the supervisor: a cluster, and the keepers of agents on its nodes."""

from typing import Protocol

from engine.remote.ray.nodes import ClusterNode


class Keeper(Protocol):
    """Keeps the agent of one node running."""

    def started(self) -> bool:
        """Return whether it runs, or has exited."""
        ...

    def ended(self) -> str | None:
        """Return the reason of its exit, or None while it runs."""
        ...

    def kill_agent(self) -> None:
        """Kill the agent; it is restarted."""
        ...

    def end(self) -> None:
        """Begin to stop the agent and this keeper."""
        ...

    def join(self, timeout: float) -> None:
        """Wait until it has exited; kill it after ``timeout`` [s]."""
        ...

    def kill(self) -> None:
        """Kill it."""
        ...


class Cluster(Protocol):
    """A cluster: lists its nodes, and keeps agents on them."""

    def nodes(self) -> list[ClusterNode]:
        """Return the nodes that can be machines."""
        ...

    def free_cores(self, node: ClusterNode) -> int:
        """Return the number of whole CPUs of a node that nothing else holds."""
        ...

    def find(self, node: ClusterNode) -> Keeper | None:
        """Return the existing keeper of a node's agent, from before a restart of the supervisor, or None."""
        ...

    def keep(self, node: ClusterNode, cores: int) -> Keeper:
        """Start a keeper of an agent on a node, and reserve this number of its cores."""
        ...
