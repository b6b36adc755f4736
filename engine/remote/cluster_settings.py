"""Settings of the cluster, which the cloud sends to a machine of another host each time before it registers."""

import msgspec

from engine.agent.config import ADOPT_WITHIN
from engine.fabric.zenoh_config import RouterCredentials
from engine.master.places import LINGER
from engine.master.quotas import Quota
from engine.protocols.versions import Protocols
from engine.runtimes.registry import DEFAULT


class ContainerSettings(msgspec.Struct, frozen=True):
    """Settings of containers, the same on all machines: none may be less strict than the administrator wants.

    Parameters
    ----------
    runtime : str
        Runtime that starts them.
    image : str
        Image of the containers, for a runtime that uses images.
    allowed : tuple of str
        Third-party plug-ins that may run, each as ``group:name`` of its entry point.
    adopt_within : float
        Time for which they outlive a killed master [s].
    """

    runtime: str = DEFAULT
    image: str = ""
    allowed: tuple[str, ...] = ()
    adopt_within: float = ADOPT_WITHIN


class EndpointSettings(msgspec.Struct, frozen=True):
    """Settings of endpoints, the same on all machines.

    Parameters
    ----------
    quota : Quota
        Quota of users without own limits.
    keep_versions : int, optional
        Number of versions of a map that are kept; None for all.
    linger : float
        Time for which the place of a robot outlives its last client [s].
    """

    quota: Quota = msgspec.field(default_factory=Quota)
    keep_versions: int | None = None
    linger: float = LINGER


class ClusterSettings(msgspec.Struct, tag="terms"):
    """Settings of one run of the cloud.

    Parameters
    ----------
    cloud : str
        Instance name of the cloud process.
    store, map_store : str
        URLs of the stores, which must be reachable from the machine.
    fabric_port : int
        Port of the cloud's router for routers of other hosts.
    fabric : RouterCredentials
        Credentials that all routers of the cloud share.
    runs : ContainerSettings
        Settings of containers.
    release : str
        Release of this program that the cloud runs.
    epoch : int
        Epoch of the master that leads.
    masters : tuple of str
        Addresses of other processes that may lead later.
    serves : EndpointSettings
        Settings of endpoints.
    protocols : Protocols, optional
        Protocol versions that the cloud speaks; None if its release states none.
    """

    cloud: str
    store: str
    map_store: str
    fabric_port: int
    fabric: RouterCredentials
    runs: ContainerSettings = ContainerSettings()
    release: str = ""
    epoch: int = 0
    masters: tuple[str, ...] = ()
    serves: EndpointSettings = EndpointSettings()
    protocols: Protocols | None = None
