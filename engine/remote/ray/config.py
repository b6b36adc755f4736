"""Settings of the processes on a Ray cluster, and the answers of the watcher."""

import msgspec

from engine.protocols.refusals import Refusal
from engine.remote.endpoint_processes import EndpointProcesses


class WatchConfig(msgspec.Struct, frozen=True):
    """The cluster to watch, and the cloud that uses it.

    Parameters
    ----------
    address : str
        ``host:port`` of the cluster's head, or ``auto`` for the cluster on this host.
    folder : str
        Folder of the cloud's certificates and tickets.
    host : str, optional
        Host name or address by which nodes reach the cloud. Default: the address of this host in the cluster.
    cores : int, optional
        Most CPUs to use of a node. Default: all free ones.
    endpoints : EndpointProcesses, optional
        Endpoints of each node; None for none.
    """

    address: str
    folder: str
    host: str | None = None
    cores: int | None = None
    endpoints: EndpointProcesses | None = None


class WatchStarted(msgspec.Struct, tag="connected"):
    """The cluster is watched."""


class WatchRefused(msgspec.Struct, tag="refused"):
    """The cluster cannot be watched."""

    refusal: Refusal


WatchAnswer = WatchStarted | WatchRefused

DONE = 3
"""Exit status of a node's agent that must not be restarted: its cloud refuses it or is unreachable."""


class NodeConfig(msgspec.Struct, frozen=True):
    """Settings of the agent of a node.

    Parameters
    ----------
    machine : str
        Name of the machine.
    ticket : str
        Ticket with which it joins the cloud.
    cores : int
        CPUs that the actor has reserved.
    labels : dict of str to str
        Labels of the node.
    folder : str
        Folder of its certificate; set on the node.
    keeper : int
        Process id of the actor that keeps it; set on the node. The agent exits with the actor.
    endpoints : EndpointProcesses, optional
        Endpoints of the node; None for none.
    """

    machine: str
    ticket: str
    cores: int
    labels: dict[str, str]
    folder: str = ""
    keeper: int = 0
    endpoints: EndpointProcesses | None = None
