"""What the processes of a Ray cluster's machines are told at their start, and what the watcher answers."""

import msgspec

from engine.protocols.robot_link import Refusal


class WatchConfig(msgspec.Struct, frozen=True):
    """Which cluster to watch, and for which cloud.

    Parameters
    ----------
    address : str
        ``host:port`` of the cluster's head, or ``auto`` for the one that was started on this host.
    folder : str
        Of the cloud's certificates and tickets.
    host : str, optional
        By which nodes reach the cloud; without it, by the address that this host has in the cluster.
    cores : int, optional
        Most CPUs to take of a node; without it, all that are free.
    """

    address: str
    folder: str
    host: str | None = None
    cores: int | None = None


class WatchStarted(msgspec.Struct, tag="connected"):
    """The cluster is watched."""


class WatchRefused(msgspec.Struct, tag="refused"):
    """It cannot be."""

    refusal: Refusal


WatchAnswer = WatchStarted | WatchRefused

DONE = 3
"""Status with which the agent of a node ends that is not to be started again: its cloud does not want it or is gone."""


class NodeConfig(msgspec.Struct, frozen=True):
    """What the agent of a node is told.

    Parameters
    ----------
    machine : str
        Name of the machine.
    ticket : str
        With which it joins the cloud.
    cores : int
        CPUs that are held for it.
    labels : dict of str to str
        Of the node.
    folder : str
        For its certificate; known on its host alone.
    keeper : int
        Process id of the actor that keeps it, with which it ends.
    """

    machine: str
    ticket: str
    cores: int
    labels: dict[str, str]
    folder: str = ""
    keeper: int = 0
