"""Options of robots that are presented as AGVs."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from ppaas.wire.vda5050.topics import Version


@dataclass(frozen=True, slots=True)
class AgvOptions:
    """Options of one or more AGVs.

    Attributes
    ----------
    version : Version
    manufacturer : str
        Second level of topics.
    interface : str
        First level of topics; empty for the version's.
    state_interval : float
        Longest time between two states [s].
    visualization_interval : float
        Time between two visualizations [s]; 0 for none.
    zones : bool
        Whether zones of the master control become masks of the robot, in 3.0.
    services : mapping of str to str
        Services of the robot (``std_srvs/Trigger``), by the type of the action that they execute.
    """

    version: Version = Version.V2_1
    manufacturer: str = "ppaas"
    interface: str = ""
    state_interval: float = 30.0
    visualization_interval: float = 1.0
    zones: bool = False
    services: Mapping[str, str] = field(default_factory=dict)
