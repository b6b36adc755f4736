"""The layers of a map, made once per version and robot radius."""

from collections.abc import Sequence

import numpy as np

from ppaas.costmap.costmap import Costmap
from ppaas.costmap.filter_masks import barred, raise_costs, sampled, spread
from ppaas.costmap.inflation_layer import COST_SCALING_FACTOR, INFLATION_RADIUS, ROBOT_RADIUS, inflate
from ppaas.costmap.map_layers import MapLayers
from ppaas.maps.distance import distance_to_occupied
from ppaas.maps.grid import UNKNOWN, GridMap


def build_layers(
    grid: GridMap,
    *,
    robot_radius: float = ROBOT_RADIUS,
    inflation_radius: float = INFLATION_RADIUS,
    cost_scaling_factor: float = COST_SCALING_FACTOR,
    keepout: GridMap | None = None,
    overhead: GridMap | None = None,
    speed: GridMap | None = None,
) -> MapLayers:
    """Derive the inflated costmap and the distances of a map, and lay masks on it.

    Parameters
    ----------
    grid : GridMap
        The map.
    robot_radius, inflation_radius : float
        [m].
    cost_scaling_factor : float
        [1/m].
    keepout, speed : GridMap, optional
        Masks of Nav2's costmap filters, of any resolution and origin, in the frame of the map. What is to be kept out
        of altogether is inflated as obstacles are.
    overhead : GridMap, optional
        Likewise, of what is ``height_mask`` of the robot.

    Raises
    ------
    InvalidParameter
        A radius or the factor is negative or not finite.
    """
    distance = to_lethal = distance_to_occupied(grid)
    zones = _together([spread(mask, grid.info) for mask in (keepout, overhead) if mask is not None])
    if zones is not None:
        to_lethal = distance_to_occupied(barred(grid, zones))
    costs = inflate(
        to_lethal,
        inscribed_radius=robot_radius,
        inflation_radius=inflation_radius,
        cost_scaling_factor=cost_scaling_factor,
        unknown=grid.data == UNKNOWN,
    )
    if zones is not None:
        raise_costs(costs, zones.data)
    return MapLayers(
        grid,
        Costmap(costs, grid.info),
        distance,
        keepout=zones,
        barred_distance=None if zones is None else to_lethal,
        speed=None if speed is None else sampled(speed, grid.info),
    )


def _together(masks: Sequence[GridMap]) -> GridMap | None:
    """Return the higher of all values, by the same cells."""
    if not masks:
        return None
    return GridMap(np.maximum.reduce([mask.data for mask in masks]), masks[0].info)
