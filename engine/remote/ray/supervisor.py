"""Supervisor: makes sure that each node of a Ray cluster that can be a machine has an agent."""

import logging
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from engine.specs.machine_settings import MOST_LABELS
from ppaas.clock import Clock, monotonic
from storage.names import is_name

logger = logging.getLogger(__name__)


# -- nodes -------------------------------------------------------------------------------------------------------------

NODE_LABEL = "ray.io/node-id"

MACHINE_NAME = 10
"""Number of characters of a node's id that name its machine; short, since names of sockets contain it."""


@dataclass(frozen=True, slots=True)
class ClusterNode:
    """A running node.

    Parameters
    ----------
    id : str
        Unique id; a host that joins again gets a new one.
    address : str
        Address of its host.
    cores : int
        Number of whole CPUs.
    labels : dict of str to str
        Labels that it was started with or got from Ray, as labels of a machine.
    """

    id: str
    address: str
    cores: int
    labels: dict[str, str] = field(default_factory=dict)

    @property
    def machine(self) -> str:
        """Name of its machine."""
        return self.id[:MACHINE_NAME]


def read_nodes(table: Iterable[Mapping[str, Any]]) -> list[ClusterNode]:
    """Return the nodes that can be machines: those that run and have at least one whole CPU.

    Parameters
    ----------
    table : iterable of mappings
        Result of ``ray.nodes()``, which contains dead nodes too.
    """
    nodes = []
    for row in table:
        cores = int(row["Resources"].get("CPU", 0.0))
        if row["Alive"] and cores >= 1:
            labels = machine_labels(row["Labels"])
            nodes.append(ClusterNode(row["NodeID"], row["NodeManagerAddress"], cores, labels))
    return nodes


class RayNodeUsage(Protocol):
    """A node in Ray's status of a cluster."""

    @property
    def node_id(self) -> str | None:
        """Its id; None before it runs."""

    def available_resources(self) -> Mapping[str, float]:
        """Return the amount of each resource that no work of Ray holds."""


def free_cores(node: ClusterNode, status: Iterable[RayNodeUsage]) -> int:
    """Return the number of whole CPUs of a node that no work of Ray holds; none of a node that the status lacks."""
    return sum(int(usage.available_resources().get("CPU", 0.0)) for usage in status if usage.node_id == node.id)


def machine_labels(labels: Mapping[str, str]) -> dict[str, str]:
    """Return the labels of a node that are valid for a machine, with ``.`` for ``/``, without the id's label.

    Labels of Ray may be empty, or as long as in Kubernetes. Labels that are not valid for a machine are omitted.
    """
    named = {key.replace("/", "."): value for key, value in labels.items() if key != NODE_LABEL}
    fitting = sorted((key, value) for key, value in named.items() if is_name(key) and is_name(value))
    return dict(fitting[:MOST_LABELS])


# -- supervisor --------------------------------------------------------------------------------------------------------

START_TIMEOUT = 30.0
"""Time limit for Ray to start an agent [s]; it cannot if other work has reserved the cores meanwhile."""

END_TIMEOUT = 10.0
"""Time for all agents together to exit by themselves before Ray kills the rest [s]."""

STEADY = 60.0
"""Uptime of an agent after which the next attempt counts as the first one again [s]."""

RETRY_DELAYS = (0.0, 1.0, 5.0, 15.0)
"""Delays before the second, third … attempt on a node [s]."""


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


@dataclass(slots=True)
class _Tries:
    """Number of starts of an agent on a node, time of the next one, and whether a warning was logged."""

    count: int = 0
    not_before: float = 0.0
    warned: bool = False


class Supervisor:
    """Compares the nodes of a cluster with the running agents, and starts the missing ones.

    Parameters
    ----------
    cluster : Cluster
        The cluster.
    cores : int, optional
        Most CPUs to use of a node. Default: all free ones.
    clock : callable
        Monotonic time [s].
    """

    def __init__(self, cluster: Cluster, cores: int | None = None, clock: Clock = monotonic) -> None:
        self._cluster = cluster
        self._cores = cores
        self._clock = clock
        self._nodes: dict[str, ClusterNode] = {}
        self._keepers: dict[str, Keeper] = {}
        self._tries: dict[str, _Tries] = {}

    @property
    def machines(self) -> list[str]:
        """Names of the machines that have an agent."""
        return [self._nodes[node].machine for node in self._keepers]

    def reconcile(self) -> None:
        """Drop nodes that have left and agents that have exited, and start missing agents. Called periodically."""
        now = {node.id: node for node in self._cluster.nodes()}
        for node in self._nodes.keys() - now.keys():
            logger.warning("node %s (%s) left the cluster", self._nodes[node].machine, self._nodes[node].address)
            self._keepers.pop(node, None)
            self._tries.pop(node, None)
        self._nodes = now
        for node in tuple(self._keepers):
            self._check(node)
        for node in now.keys() - self._keepers.keys():
            self._start(now[node])

    def _check(self, node: str) -> None:
        keeper, tries = self._keepers[node], self._tries[node]
        reason = keeper.ended()
        if reason is None:
            if keeper.started() or self._clock() < tries.not_before + START_TIMEOUT:
                return
            reason = f"Ray did not start it within {START_TIMEOUT:g} s"
            keeper.kill()
        logger.warning("the agent of node %s has exited and is restarted: %s", self._nodes[node].machine, reason)
        del self._keepers[node]
        if self._clock() - tries.not_before > STEADY:
            tries.count = 1
        tries.not_before = self._clock() + RETRY_DELAYS[min(tries.count, len(RETRY_DELAYS)) - 1]

    def _start(self, node: ClusterNode) -> None:
        tries = self._tries.setdefault(node.id, _Tries(not_before=self._clock()))
        if self._clock() < tries.not_before:
            return
        keeper = self._cluster.find(node) or self._start_new(node, tries)
        if keeper is not None:
            self._keepers[node.id] = keeper
            tries.count, tries.not_before, tries.warned = tries.count + 1, self._clock(), False

    def _start_new(self, node: ClusterNode, tries: _Tries) -> Keeper | None:
        # Ray itself lets an actor that asks for too many cores wait without a message.
        free = self._cluster.free_cores(node)
        cores = min(free, self._cores or free)
        if cores < 1:  # Ray would queue it without an error
            if not tries.warned:
                tries.warned = True
                logger.warning("node %s has no free core: other work has reserved all %d", node.machine, node.cores)
            return None
        logger.info("node %s (%s) becomes a machine with %d cores", node.machine, node.address, cores)
        return self._cluster.keep(node, cores)

    def kill_agent(self, machine: str) -> None:
        """Kill the agent of a machine; it is restarted."""
        for node, keeper in self._keepers.items():
            if self._nodes[node].machine == machine:
                keeper.kill_agent()

    def end_all(self) -> None:
        """Stop all agents, and wait until they have exited."""
        for keeper in self._keepers.values():
            keeper.end()
        deadline = self._clock() + END_TIMEOUT
        for keeper in self._keepers.values():
            keeper.join(max(0.0, deadline - self._clock()))
        self._keepers.clear()
