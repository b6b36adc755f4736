"""What the cloud tells a machine of another host each time before it registers: where things are kept, and by whom."""

import msgspec

from engine.agent.master_redial import ADOPT_WITHIN
from engine.fabric.zenoh_config import RouterCredentials
from engine.runtimes.registry import DEFAULT


class ContainerSettings(msgspec.Struct, frozen=True):
    """How containers run, on all machines alike: none must be less strict with them than the administrator wants.

    Parameters
    ----------
    runtime : str
        Starts them.
    image : str
        Image that they run from, for a runtime that has images.
    allowed : tuple of str
        Other people's plug-ins that may run, each as ``group:name`` of its entry point.
    adopt_within : float
        Seconds for which they outlive a master that was killed.
    """

    runtime: str = DEFAULT
    image: str = ""
    allowed: tuple[str, ...] = ()
    adopt_within: float = ADOPT_WITHIN


class ClusterSettings(msgspec.Struct, tag="terms"):
    """Of one run of the cloud.

    Parameters
    ----------
    cloud : str
        Name of the cloud process.
    store, map_store : str
        URLs of the stores, which the machine must reach by the same.
    fabric_port : int
        Where the cloud's router takes those of other hosts.
    fabric : RouterCredentials
        Of all routers of the cloud.
    runs : ContainerSettings
        How containers run.
    release : str
        Of this program, that the cloud runs.
    """

    cloud: str
    store: str
    map_store: str
    fabric_port: int
    fabric: RouterCredentials
    runs: ContainerSettings = ContainerSettings()
    release: str = ""
