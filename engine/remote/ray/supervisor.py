"""Sees to it that each node of a cluster has an agent, whatever joins, leaves or dies."""

import logging
from dataclasses import dataclass

from engine.remote.ray.nodes import ClusterNode
from engine.remote.ray.ports import Cluster, Keeper
from ppaas.clock import Clock, monotonic

logger = logging.getLogger(__name__)

START_TIMEOUT = 30.0
"""Seconds after which an agent that Ray has not started is given up: other work took the cores in between."""

END_TIMEOUT = 10.0
"""Seconds that all agents together have to end by themselves, before Ray ends those that are left by force."""

STEADY = 60.0
"""Seconds after which an agent has run so long that the next try is a first one again."""

RETRY_DELAYS = (0.0, 1.0, 5.0, 15.0)
"""Seconds before the second, third … try on a node."""


@dataclass(slots=True)
class _Tries:
    """How often an agent was begun on a node, and when the next may be."""

    count: int = 0
    not_before: float = 0.0
    told: bool = False


class Supervisor:
    """Looks at the cluster from time to time, and does what is missing.

    Parameters
    ----------
    cluster : Cluster
        That is looked at.
    cores : int, optional
        Most CPUs to take of a node; without it, all that are free.
    clock : callable
        Monotonic seconds.
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
        """Names of the machines on which an agent is kept."""
        return [self._nodes[node].machine for node in self._keepers]

    def look(self) -> None:
        """Forget nodes that left and agents that ended, and begin those that are missing."""
        now = {node.id: node for node in self._cluster.nodes()}
        for node in self._nodes.keys() - now.keys():
            logger.warning("node %s (%s) left the cluster", self._nodes[node].machine, self._nodes[node].address)
            self._keepers.pop(node, None)
            self._tries.pop(node, None)
        self._nodes = now
        for node in tuple(self._keepers):
            self._look_after(node)
        for node in now.keys() - self._keepers.keys():
            self._begin(now[node])

    def _look_after(self, node: str) -> None:
        keeper, tries = self._keepers[node], self._tries[node]
        reason = keeper.ended()
        if reason is None:
            if keeper.started() or self._clock() < tries.not_before + START_TIMEOUT:
                return
            reason = f"Ray did not start it within {START_TIMEOUT:g} s"
            keeper.kill()
        logger.warning("the agent of node %s is gone and begun anew: %s", self._nodes[node].machine, reason)
        del self._keepers[node]
        if self._clock() - tries.not_before > STEADY:
            tries.count = 1
        tries.not_before = self._clock() + RETRY_DELAYS[min(tries.count, len(RETRY_DELAYS)) - 1]

    def _begin(self, node: ClusterNode) -> None:
        tries = self._tries.setdefault(node.id, _Tries(not_before=self._clock()))
        if self._clock() < tries.not_before:
            return
        keeper = self._cluster.find(node) or self._begin_new(node, tries)
        if keeper is not None:
            self._keepers[node.id] = keeper
            tries.count, tries.not_before, tries.told = tries.count + 1, self._clock(), False

    def _begin_new(self, node: ClusterNode, tries: _Tries) -> Keeper | None:
        cores = min(node.free, self._cores or node.free)
        if cores < 1:  # Ray would let it wait without a word
            if not tries.told:
                tries.told = True
                logger.warning("node %s has no free core of its %d: other work holds them", node.machine, node.cores)
            return None
        logger.info("node %s (%s) is taken in with %d cores", node.machine, node.address, cores)
        return self._cluster.keep(node, cores)

    def kill_agent(self, machine: str) -> None:
        """End the agent of a machine by force: it is started again."""
        for node, keeper in self._keepers.items():
            if self._nodes[node].machine == machine:
                keeper.kill_agent()

    def end_all(self) -> None:
        """End all agents, and wait until they have."""
        for keeper in self._keepers.values():
            keeper.end()
        deadline = self._clock() + END_TIMEOUT
        for keeper in self._keepers.values():
            keeper.join(max(0.0, deadline - self._clock()))
        self._keepers.clear()
