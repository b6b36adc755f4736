"""What the cloud tells a machine of another host each time before it registers: where things are kept, and by whom."""

import msgspec

from engine.runtimes.registry import DEFAULT
from engine.zenoh_config import Credentials


class Runs(msgspec.Struct, frozen=True):
    """How containers run, on all machines alike: none must be less strict with them than the administrator wants.

    Parameters
    ----------
    runtime : str
        Starts them.
    image : str
        Image that they run from, for a runtime that has images.
    allowed : tuple of str
        Other people's plug-ins that may run, each as ``group:name`` of its entry point.
    """

    runtime: str = DEFAULT
    image: str = ""
    allowed: tuple[str, ...] = ()


class Terms(msgspec.Struct, tag="terms"):
    """Of one run of the cloud.

    Parameters
    ----------
    cloud : str
        Name of the cloud process.
    store, map_store : str
        URLs of the stores, which the machine must reach by the same.
    fabric_port : int
        Where the cloud's router takes those of other hosts.
    fabric : Credentials
        Of all routers of the cloud.
    runs : Runs
        How containers run.
    """

    cloud: str
    store: str
    map_store: str
    fabric_port: int
    fabric: Credentials
    runs: Runs = Runs()
