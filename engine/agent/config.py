"""Configuration of an agent, which it reads at its start."""

import msgspec

from engine.fabric.zenoh_config import Peering
from engine.runtimes.registry import DEFAULT

ADOPT_WITHIN = 30.0
"""Default time for which containers outlive their master [s]."""


class AgentConfig(msgspec.Struct, frozen=True):
    """Configuration of an agent: its master, stores, folders and resources.

    Parameters
    ----------
    machine : str
        Name of the machine.
    control : str
        Address of the control link: path of a Unix socket, or ``tls://host:port``.
    secret : str
        Authenticates the agent to the master.
    run_dir : str
        Folder for its sockets.
    cloud : str
        Name of the cloud process that starts this agent.
    store, map_store : str
        URLs of the stores.
    outbox : str, optional
        File that queues plans while a store on another machine is unavailable.
    reserve : str, optional
        Folder with the cloud's reserve of disk space, if it is on this machine.
    recordings : str, optional
        Folder of the recordings of robots; None if this machine keeps none.
    cores : int, optional
        Number of CPUs that the machine may use; all of them by default.
    labels : dict of str to str
        Labels of the machine.
    peering : Peering, optional
        How its router connects to the routers of other hosts.
    endpoints : str, optional
        Folder of the sockets of the endpoints on this machine; by default, its own sockets' folder.
    identity : str, optional
        Folder with its key and certificates, if the master is on another host.
    runtime : str
        Name of the runtime plug-in that starts its containers.
    image : str
        Image of its containers, for a runtime that uses images.
    allowed : tuple of str
        Third-party plug-ins that may run, each as ``group:name`` of its entry point.
    adopt_within : float
        Time for which its containers outlive a master that was killed [s].
    """

    machine: str
    control: str
    secret: str
    run_dir: str
    cloud: str
    store: str
    map_store: str
    outbox: str | None = None
    reserve: str | None = None
    recordings: str | None = None
    cores: int | None = None
    labels: dict[str, str] = {}
    peering: Peering | None = None
    endpoints: str | None = None
    identity: str | None = None
    runtime: str = DEFAULT
    image: str = ""
    allowed: tuple[str, ...] = ()
    adopt_within: float = ADOPT_WITHIN
