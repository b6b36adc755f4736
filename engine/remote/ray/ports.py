"""What keeps agents on the nodes of a cluster, as the supervisor knows it."""

from typing import Protocol

from engine.remote.ray.nodes import ClusterNode


class Keeper(Protocol):
    """What keeps the agent of one node running."""

    def started(self) -> bool:
        """Tell whether it runs, or has ended."""
        ...

    def ended(self) -> str | None:
        """Return why it ended, or None while it has not."""
        ...

    def kill_agent(self) -> None:
        """End the agent by force: it is started again."""
        ...

    def end(self) -> None:
        """Begin to end the agent and what keeps it."""
        ...

    def join(self, timeout: float) -> None:
        """Wait until it has ended; by force, if it takes longer than so many seconds."""
        ...

    def kill(self) -> None:
        """End it by force."""
        ...


class Cluster(Protocol):
    """Tells of nodes, and has agents kept on them."""

    def nodes(self) -> list[ClusterNode]:
        """Return those that can be machines."""
        ...

    def find(self, node: ClusterNode) -> Keeper | None:
        """Return what keeps the agent of a node already, from before the supervisor was started anew."""
        ...

    def keep(self, node: ClusterNode, cores: int) -> Keeper:
        """Have an agent kept on a node, which holds so many of its cores."""
        ...
