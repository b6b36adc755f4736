"""Messages on the zones of a map."""

from ppaas.messages.base.message import Empty, OwnMessage, ServiceType

PACKAGE = "ppaas_msgs"


class ZonesOfMap(OwnMessage):
    """Zones of a map, as GeoJSON in metres in the frame of the map."""

    geojson: str


GetZones = ServiceType("ppaas_msgs/GetZones", Empty, ZonesOfMap)
"""Service that returns the zones of a map."""

SERVICES = (GetZones,)
