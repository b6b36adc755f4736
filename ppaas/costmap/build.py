"""The layers of a map, made once per version and robot radius."""

from ppaas.costmap.costmap import Costmap
from ppaas.costmap.inflation import COST_SCALING_FACTOR, INFLATION_RADIUS, ROBOT_RADIUS, inflate
from ppaas.maps.distance import distance_to_occupied
from ppaas.maps.grid import UNKNOWN, GridMap
from ppaas.maps.layers import MapLayers


def build_layers(
    grid: GridMap,
    *,
    robot_radius: float = ROBOT_RADIUS,
    inflation_radius: float = INFLATION_RADIUS,
    cost_scaling_factor: float = COST_SCALING_FACTOR,
) -> MapLayers:
    """Derive the inflated costmap and the distances of a map.

    Parameters
    ----------
    grid : GridMap
        The map.
    robot_radius, inflation_radius : float
        [m].
    cost_scaling_factor : float
        [1/m].

    Raises
    ------
    InvalidParameter
        A radius or the factor is negative or not finite.
    """
    distance = distance_to_occupied(grid)
    costs = inflate(
        distance,
        inscribed_radius=robot_radius,
        inflation_radius=inflation_radius,
        cost_scaling_factor=cost_scaling_factor,
        unknown=grid.data == UNKNOWN,
    )
    return MapLayers(grid, Costmap(costs, grid.info), distance)
