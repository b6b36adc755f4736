"""The Ray cluster behind what the supervisor knows of it."""

import contextlib
import logging
from pathlib import Path
from typing import Any

import msgspec
import ray
from ray._private.state import available_resources_per_node  # nothing public tells it by node
from ray.exceptions import RayError
from ray.util import get_node_ip_address
from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy

from engine.remote.authority import Authority
from engine.remote.machines import make_ticket
from engine.remote.ray.actor import AgentActor
from engine.remote.ray.config import NodeConfig, WatchConfig
from engine.remote.ray.nodes import ClusterNode, read_nodes
from ppaas.errors import Unavailable

TICKET_VALID = 300.0
"""Seconds; the first worker of a node may take some of them to start."""


class RayKeeper:
    """An actor that keeps an agent (``engine.remote.ray.actor``).

    Parameters
    ----------
    actor : ActorHandle
        Of it.
    """

    def __init__(self, actor: Any) -> None:
        self._actor = actor
        self._up = actor.is_up.remote()
        self._life = actor.live.remote()

    def started(self) -> bool:
        """Tell whether it runs, or has ended."""
        return _is_done(self._up)

    def ended(self) -> str | None:
        """Return why it ended, or None while it has not."""
        if _is_done(self._life):
            try:
                ray.get(self._life)
            except RayError as error:
                return str(error).strip()
        return None

    def kill_agent(self) -> None:
        """End the agent by force: it is started again."""
        self._actor.kill_agent.remote()

    def end(self) -> None:
        """Begin to end the agent and what keeps it."""
        self._actor.stop.remote()

    def join(self, timeout: float) -> None:
        """Wait until it has ended; by force, if it takes longer than so many seconds."""
        with contextlib.suppress(RayError):  # which tells that it has gone, or that it is time
            ray.get(self._life, timeout=timeout)
        self.kill()

    def kill(self) -> None:
        """End it by force."""
        ray.kill(self._actor, no_restart=True)


class RayCluster:
    """A cluster that this process takes part in.

    Parameters
    ----------
    config : WatchConfig
        Which, and for which cloud. The names of the agents are the cloud's own, so that it finds them again when it was
        started anew.

    Raises
    ------
    Unavailable
        There is none, or it does not let us in.
    """

    def __init__(self, config: WatchConfig) -> None:
        self._folder = Path(config.folder)
        self._host = config.host
        # Of several nodes on a host with one network each, ours is the one at the head's address.
        host = config.address.rpartition(":")[0]
        own: dict[str, Any] = {"_node_ip_address": host} if host.startswith("127.") else {}
        cloud = Authority(self._folder).fingerprint
        try:
            ray.init(config.address, namespace=cloud, log_to_driver=False, logging_level=logging.WARNING, **own)
        except (ConnectionError, RuntimeError, ValueError, RayError) as error:
            raise Unavailable(
                f"the Ray cluster at {config.address} does not let us in: {error}; see that this host is a node of it "
                "(ray start), and that RAY_AUTH_MODE, RAY_AUTH_TOKEN and RAY_AUTH_TOKEN_PATH are as there"
            ) from error

    def nodes(self) -> list[ClusterNode]:
        """Return those that can be machines."""
        return read_nodes(ray.nodes(), available_resources_per_node())  # type: ignore[no-untyped-call]

    def find(self, node: ClusterNode) -> RayKeeper | None:
        """Return what keeps the agent of a node already."""
        try:
            return RayKeeper(ray.get_actor(_name(node)))
        except ValueError:
            return None

    def keep(self, node: ClusterNode, cores: int) -> RayKeeper:
        """Have an agent kept on a node.

        The actor is detached: it goes on while this process, or the node on which it runs, is started anew.
        """
        host = self._host or get_node_ip_address()  # type: ignore[no-untyped-call]
        ticket = make_ticket(self._folder, valid=TICKET_VALID, machine=node.machine, host=host)
        config = NodeConfig(node.machine, str(ticket), cores, node.labels)
        actor: Any = ray.remote(AgentActor).options(
            name=_name(node),
            lifetime="detached",
            num_cpus=cores,
            max_restarts=0,  # who watches starts another, on the nodes that there are then
            scheduling_strategy=NodeAffinitySchedulingStrategy(node.id, soft=False),
        )
        return RayKeeper(actor.remote(msgspec.json.encode(config)))


def _name(node: ClusterNode) -> str:
    return f"agent-{node.id}"


def _is_done(reference: Any) -> bool:
    done, _ = ray.wait([reference], timeout=0)
    return bool(done)
