"""Zones of the cloud's map for one AGV: those that it can respect, as a set of VDA 5050."""

import logging
from collections.abc import Sequence

from ppaas.wire.vda5050.factsheets import Factsheet
from ppaas.wire.vda5050.map_zones import expressed_zones
from ppaas.wire.vda5050.master.zone_control import ZoneControl, zone_set_of
from ppaas.wire.vda5050.topics import Version
from ppaas.wire.vda5050.zones import Zone as AgvZone
from ppaas.zones.zone import Zone
from robots.bridges.agv.limits import top_speed_of

logger = logging.getLogger(__name__)

SENT = ("BLOCKED", "SPEED_LIMIT", "DIRECTED")
"""Types of zones that are sent. An AGV would wait for access to a RELEASE zone, which the bridge does not grant."""


class ZoneSide:
    """Zones of one AGV.

    Parameters
    ----------
    name : str
        Manufacturer and serial number, for the log.

    Attributes
    ----------
    control : ZoneControl
        Decides what the AGV gets.
    """

    def __init__(self, name: str) -> None:
        self.control = ZoneControl()
        self._name = name
        self._given: tuple[Sequence[Zone], str, Factsheet] | None = None
        self._told = ""

    def take(self, zones: Sequence[Zone], map_id: str, sheet: Factsheet | None, version: Version) -> None:
        """Take the zones in force; the same sequence again changes nothing.

        Parameters
        ----------
        zones : sequence of Zone
            Zones in force on the AGV's map.
        map_id : str
            The map, as the AGV names it.
        sheet : Factsheet or None
            Factsheet of the AGV, if it has sent one.
        version : Version
            Version that the AGV speaks.
        """
        if sheet is None or version.major < 3:
            if zones:
                reason = f"it speaks VDA 5050 {version.value}" if version.major < 3 else "it sends no factsheet"
                self._tell(f"zones of the map are not sent: {reason}")
            return
        before = self._given
        if before is not None and before[0] is zones and before[1:] == (map_id, sheet):
            return
        self._given = zones, map_id, sheet
        self.control.want(zone_set_of(map_id, self._respected(zones, sheet)))

    def _respected(self, zones: Sequence[Zone], sheet: Factsheet) -> list[AgvZone]:
        """Return the zones that the AGV can respect; the log names the others."""
        expressed, problems = expressed_zones(zones, top_speed_of(sheet))
        kind = sheet.type_specification
        supported = (kind and kind.supported_zones) or []
        found = []
        for zone in expressed:
            if zone.zone_type not in SENT:
                problems.append(f"zone {zone.zone_id!r} is {zone.zone_type}, to which the bridge grants no access")
            elif zone.zone_type not in supported:
                problems.append(f"the AGV does not support {zone.zone_type} (zone {zone.zone_id!r})")
            else:
                found.append(zone)
        if problems:
            self._tell("zones of the map are left out: " + "; ".join(problems))
        return found

    def _tell(self, text: str) -> None:
        if text != self._told:
            logger.warning("AGV %s: %s", self._name, text)
        self._told = text
