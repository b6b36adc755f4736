"""Layers of a map while keep-out zones with times are in force."""

from dataclasses import replace

import numpy as np

from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.global_parameters import CostParameters
from ppaas.costmap.map_layers import MapLayers, with_causes
from ppaas.maps.grid import FREE, OCCUPIED, GridMap
from ppaas.zones.masks import kept_out
from ppaas.zones.zone import Zone


def with_closed(layers: MapLayers, closed: list[Zone], robot_radius: float, costs: CostParameters) -> MapLayers:
    """Return layers in which robots keep out of some more zones.

    Parameters
    ----------
    layers : MapLayers
        Layers of the map, without these zones.
    closed : list of Zone
        Zones of the kind ``keep_out``.
    robot_radius : float
        Radius of the robot [m].
    costs : CostParameters
        Parameters of its costs, with which the layers were made.
    """
    info = layers.grid.info
    mask = kept_out(info, closed)
    if mask is None:
        return layers
    keepout = np.where(mask, np.int8(OCCUPIED), np.int8(FREE))
    if layers.keepout is not None:
        keepout = np.maximum(keepout, layers.keepout.data)
    made = build_layers(
        layers.grid,
        robot_radius=robot_radius,
        inflation_radius=costs.inflation_radius,
        cost_scaling_factor=costs.cost_scaling_factor,
        lethal_cost_threshold=costs.lethal_cost_threshold,
        keepout=GridMap(keepout, info),
        distance=layers.distance,
    )
    return with_causes(replace(made, speed=layers.speed, zones=layers.zones, overhead=layers.overhead))
