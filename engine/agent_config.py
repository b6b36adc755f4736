"""What an agent is told at its start."""

import msgspec


class AgentConfig(msgspec.Struct, frozen=True):
    """How a machine finds its master, its stores and its folders.

    Parameters
    ----------
    machine : str
        Name of the machine.
    control : str
        Unix socket of the master.
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
