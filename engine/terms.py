"""What the cloud tells a machine of another host each time before it registers: where things are kept, and by whom."""

import msgspec

from engine.zenoh_config import Credentials


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
    """

    cloud: str
    store: str
    map_store: str
    fabric_port: int
    fabric: Credentials
