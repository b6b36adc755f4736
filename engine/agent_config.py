"""What an agent is told at its start."""

import msgspec

from engine.runtimes.registry import DEFAULT
from engine.zenoh_config import Peering


class Away(msgspec.Struct, frozen=True):
    """How a machine is part of a cloud of another host.

    Parameters
    ----------
    identity : str
        Folder with its key and certificates.
    cloud : str
        Name of the cloud process, by which checkpoints are known as its own.
    """

    identity: str
    cloud: str


class AgentConfig(msgspec.Struct, frozen=True):
    """How a machine finds its master, its stores and its folders.

    Parameters
    ----------
    machine : str
        Name of the machine.
    control : str
        Where the master takes machines: a Unix socket, or ``tls://host:port``.
    secret : str
        Shows the master that the agent is ours.
    run_dir : str
        Folder for its sockets.
    instance : str
        Name of the cloud this machine belongs to; its shared memory is found by it.
    store, map_store : str
        URLs of the stores.
    outbox : str, optional
        File in which plans wait while a store that is not on this machine is away.
    cores : int, optional
        CPUs it may use; without it, all.
    labels : dict of str to str
        What the machine is like.
    peering : Peering, optional
        How its router reaches those of other hosts.
    away : Away, optional
        What it must know where the master is on another host.
    runtime : str
        Starts its containers.
    image : str
        Image that containers run from, for a runtime that has images.
    allowed : tuple of str
        Other people's plug-ins that may run, each as ``group:name`` of its entry point.
    """

    machine: str
    control: str
    secret: str
    run_dir: str
    instance: str
    store: str
    map_store: str
    outbox: str | None = None
    cores: int | None = None
    labels: dict[str, str] = {}
    peering: Peering | None = None
    away: Away | None = None
    runtime: str = DEFAULT
    image: str = ""
    allowed: tuple[str, ...] = ()
