"""Implementation of the supervisor's ``Cluster`` and ``Keeper`` by Ray."""

import contextlib
import logging
from pathlib import Path
from typing import Any

import msgspec
import ray
from ray.autoscaler.v2.sdk import get_cluster_status
from ray.exceptions import RayError
from ray.util import get_node_ip_address
from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy

from engine.remote.authority import Authority
from engine.remote.endpoint_processes import at_address
from engine.remote.machines import make_ticket
from engine.remote.ray.actor import AgentActor
from engine.remote.ray.config import NodeConfig, WatchConfig
from engine.remote.ray.supervisor import ClusterNode, free_cores, read_nodes
from ppaas.errors import Unavailable

TICKET_VALID = 300.0
"""Validity of a node's ticket [s]; the first worker of a node may take some time to start."""


class RayKeeper:
    """Handle of an actor that keeps an agent (``engine.remote.ray.actor``).

    Parameters
    ----------
    actor : ActorHandle
        Ray's handle of the actor.
    """

    def __init__(self, actor: Any) -> None:
        self._actor = actor
        self._up = actor.is_up.remote()
        self._life = actor.live.remote()

    def started(self) -> bool:
        """Return whether it runs, or has exited."""
        return _is_done(self._up)

    def ended(self) -> str | None:
        """Return the reason of its exit, or None while it runs."""
        if _is_done(self._life):
            try:
                ray.get(self._life)
            except RayError as error:
                return str(error).strip()
        return None

    def kill_agent(self) -> None:
        """Kill the agent; it is restarted."""
        self._actor.kill_agent.remote()

    def end(self) -> None:
        """Begin to stop the agent and its actor."""
        self._actor.stop.remote()

    def join(self, timeout: float) -> None:
        """Wait until it has exited; kill it after ``timeout`` [s]."""
        with contextlib.suppress(RayError):  # raised when the actor has exited, or at the timeout
            ray.get(self._life, timeout=timeout)
        self.kill()

    def kill(self) -> None:
        """Kill the actor."""
        ray.kill(self._actor, no_restart=True)


class RayCluster:
    """A Ray cluster that this process is connected to.

    Parameters
    ----------
    config : WatchConfig
        The cluster, and the cloud that uses it. The actors are in a Ray namespace of the cloud, so that it finds them
        again after a restart.

    Raises
    ------
    Unavailable
        The cluster does not exist, or refuses the connection.
    """

    def __init__(self, config: WatchConfig) -> None:
        self._folder = Path(config.folder)
        self._host = config.host
        self._endpoints = config.endpoints
        # If several nodes run on this host, each with its own loopback address, ours is the one at the head's address.
        host = config.address.rpartition(":")[0]
        own: dict[str, Any] = {"_node_ip_address": host} if host.startswith("127.") else {}
        cloud = Authority(self._folder).fingerprint
        try:
            ray.init(config.address, namespace=cloud, log_to_driver=False, logging_level=logging.WARNING, **own)
        except (ConnectionError, RuntimeError, ValueError, RayError) as error:
            raise Unavailable(
                f"the Ray cluster at {config.address} refuses the connection: {error}; check that this host is "
                "a node of it (ray start), and that RAY_AUTH_MODE, RAY_AUTH_TOKEN and RAY_AUTH_TOKEN_PATH are as there"
            ) from error

    def nodes(self) -> list[ClusterNode]:
        """Return the nodes that can be machines."""
        return read_nodes(ray.nodes())  # type: ignore[no-untyped-call]

    def free_cores(self, node: ClusterNode) -> int:
        """Return the number of whole CPUs of a node that no other work of Ray holds.

        ``ray.available_resources`` adds up all nodes. The status of the cluster, which Ray computes also where nothing
        scales the cluster, has each node.
        """
        status = get_cluster_status(ray.get_runtime_context().gcs_address)
        return free_cores(node, [*status.active_nodes, *status.idle_nodes])

    def find(self, node: ClusterNode) -> RayKeeper | None:
        """Return the existing keeper of a node's agent, or None."""
        try:
            return RayKeeper(ray.get_actor(_name(node)))
        except ValueError:
            return None

    def keep(self, node: ClusterNode, cores: int) -> RayKeeper:
        """Start an actor that keeps an agent on a node.

        The actor is detached: it runs on while this process, or the node that this process runs on, is restarted.
        """
        host = self._host or get_node_ip_address()  # type: ignore[no-untyped-call]
        ticket = make_ticket(self._folder, valid=TICKET_VALID, machine=node.machine, host=host)
        endpoints = None if self._endpoints is None else at_address(self._endpoints, node.address)
        config = NodeConfig(node.machine, str(ticket), cores, node.labels, endpoints=endpoints)
        actor: Any = ray.remote(AgentActor).options(
            name=_name(node),
            lifetime="detached",
            # The actor itself holds the cores: a placement group would be one more object that could be left behind.
            num_cpus=cores,
            max_restarts=0,  # the supervisor starts another, on the nodes that exist then
            scheduling_strategy=NodeAffinitySchedulingStrategy(node.id, soft=False),
        )
        return RayKeeper(actor.remote(msgspec.json.encode(config)))


def _name(node: ClusterNode) -> str:
    return f"agent-{node.id}"


def _is_done(reference: Any) -> bool:
    done, _ = ray.wait([reference], timeout=0)
    return bool(done)
