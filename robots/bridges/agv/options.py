"""Options of AGVs that are taken as robots."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from ppaas.wire.vda5050.master.settings import Settings
from ppaas.wire.vda5050.topics import Address
from ppaas.wire.vda5050.versions import Version

OWN_MANUFACTURER = "ppaas"
"""Manufacturer of robots of the cloud that are presented as AGVs: they are not taken as robots again."""

MAJORS = {f"v{version.major}": version.interface for version in Version}
"""Major versions that are served, with the first level of their topics."""


@dataclass(frozen=True, slots=True)
class FleetOptions:
    """Options of a fleet of AGVs.

    Attributes
    ----------
    robots : mapping of str to str
        Id of the robot of each AGV, by ``MANUFACTURER/SERIAL``. If it is empty, all AGVs of the broker are taken.
    maps : mapping of str to str
        Id of the cloud's map, by the id that AGVs have for it; the same id where it is missing.
    interface : str
        First level of topics; empty for that of the version.
    register : bool
        Whether AGVs that are not yet robots of the account are registered.
    radius : float or None
        Radius of AGVs that send no factsheet [m].
    settings : Settings
        Settings of the master control.
    """

    robots: Mapping[str, str] = field(default_factory=dict)
    maps: Mapping[str, str] = field(default_factory=dict)
    interface: str = ""
    register: bool = True
    radius: float | None = None
    settings: Settings = field(default_factory=Settings)

    def robot_of(self, address: Address) -> str | None:
        """Return the id of the robot that an AGV is; None if the AGV is not taken.

        An AGV without an id of its own is the robot of its serial number.
        """
        if self.robots:
            return self.robots.get(address.agv)
        if address.manufacturer == OWN_MANUFACTURER:
            return None
        return re.sub(r"[^A-Za-z0-9_-]", "_", address.serial)

    def map_of(self, map_id: str) -> str:
        """Return the id of the cloud's map that an AGV calls ``map_id``."""
        return self.maps.get(map_id, map_id)
