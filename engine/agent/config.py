"""What an agent is told at its start."""

import msgspec

from engine.agent.master_redial import ADOPT_WITHIN
from engine.fabric.zenoh_config import Peering
from engine.runtimes.registry import DEFAULT


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
    cloud : str
        Name of the cloud process that this machine belongs to at its start.
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
    identity : str, optional
        Folder with its key and certificates, where the master is on another host.
    runtime : str
        Starts its containers.
    image : str
        Image that containers run from, for a runtime that has images.
    allowed : tuple of str
        Other people's plug-ins that may run, each as ``group:name`` of its entry point.
    adopt_within : float
        Seconds for which what it carries outlives a master that was killed.
    """

    machine: str
    control: str
    secret: str
    run_dir: str
    cloud: str
    store: str
    map_store: str
    outbox: str | None = None
    cores: int | None = None
    labels: dict[str, str] = {}
    peering: Peering | None = None
    identity: str | None = None
    runtime: str = DEFAULT
    image: str = ""
    allowed: tuple[str, ...] = ()
    adopt_within: float = ADOPT_WITHIN
