"""Options of AGVs that are taken as robots, and the settings of the master control that a factsheet gives."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from hashlib import blake2b

from ppaas.wire.vda5050.factsheets import Factsheet
from ppaas.wire.vda5050.master.settings import Settings
from ppaas.wire.vda5050.topics import AgvAddress, Version

OWN_MANUFACTURER = "ppaas"
"""Manufacturer of robots of the cloud that are presented as AGVs: they are not taken as robots again."""

MAJORS = {f"v{version.major}": version.interface for version in Version}
"""Major versions that are served, with the first level of their topics."""


MAX_ID, DIGITS = 64, 8
"""Largest length of the id of a robot, and number of hexadecimal digits at its end if need be [characters]."""


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
        First level of topics; empty for the version's.
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

    def takes(self, address: AgvAddress) -> bool:
        """Return whether an AGV is taken as a robot."""
        return address.agv in self.robots if self.robots else address.manufacturer != OWN_MANUFACTURER

    def robots_of(self, address: AgvAddress) -> tuple[str, ...]:
        """Return the ids that the robot of an AGV may have, the first of them if it can; none if it is not taken.

        Without an option it is the robot of its serial number. A serial number is one of its manufacturer alone, and
        ids lack some of its characters; so the next ids have the manufacturer, and digits made of both.
        """
        if not self.takes(address):
            return ()
        if self.robots:
            return (self.robots[address.agv],)
        whole = f"{address.manufacturer}_{address.serial}"
        digits = blake2b(address.agv.encode(), digest_size=DIGITS // 2).hexdigest()
        return _id(address.serial), _id(whole), f"{_id(whole)[: MAX_ID - DIGITS - 1]}_{digits}"

    def map_of(self, map_id: str) -> str:
        """Return the id of the cloud's map that an AGV calls ``map_id``."""
        return self.maps.get(map_id, map_id)


def _id(text: str) -> str:
    """Return a text as the id of a robot: letters, digits, ``_`` and ``-``, a letter or digit first."""
    return re.sub(r"[^A-Za-z0-9_-]", "_", text).lstrip("_-")[:MAX_ID] or "agv"


LEAST_NODES = 2
"""Number of nodes that an order needs to lead anywhere."""


def settings_of(sheet: Factsheet, usual: Settings) -> Settings:
    """Return the settings with the top speed and the largest number of nodes that a factsheet gives."""
    limits = sheet.protocol_limits
    nodes = 0 if limits is None else limits.maximum_array_lengths.get("order.nodes", 0)
    return replace(
        usual,
        top_speed=top_speed_of(sheet) or usual.top_speed,
        max_nodes=min(usual.max_nodes, nodes) if nodes >= LEAST_NODES else usual.max_nodes,
    )


def top_speed_of(sheet: Factsheet) -> float | None:
    """Return the top speed that a factsheet gives [m/s]; None if it gives none that an AGV could have."""
    if (body := sheet.physical_parameters) is None:
        return None
    return body.maximum_speed if math.isfinite(body.maximum_speed) and body.maximum_speed > 0.0 else None
