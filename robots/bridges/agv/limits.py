"""Settings of the master control for one AGV, by its factsheet."""

import math
from dataclasses import replace

from ppaas.wire.vda5050.factsheets import Factsheet
from ppaas.wire.vda5050.master.settings import Settings

LEAST_NODES = 2
"""Number of nodes that an order needs to lead anywhere."""


def settings_of(sheet: Factsheet, usual: Settings) -> Settings:
    """Return the settings with the top speed and the largest number of nodes that a factsheet gives."""
    speed = sheet.physical_parameters.maximum_speed
    nodes = sheet.protocol_limits.maximum_array_lengths.get("order.nodes", 0)
    return replace(
        usual,
        top_speed=speed if math.isfinite(speed) and speed > 0.0 else usual.top_speed,
        max_nodes=min(usual.max_nodes, nodes) if nodes >= LEAST_NODES else usual.max_nodes,
    )
