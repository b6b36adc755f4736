"""Settings of the master control for one AGV, by its factsheet."""

import math
from dataclasses import replace

from ppaas.wire.vda5050.factsheets import Factsheet
from ppaas.wire.vda5050.master.settings import Settings

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
