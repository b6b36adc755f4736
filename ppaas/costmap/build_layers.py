"""Construction of a map's layers: once per map version and robot radius, while keep-out zones with times close, and
while a robot carries a load."""

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.costmap.filter_masks import barred, raise_costs, sampled, spread
from ppaas.costmap.global_parameters import CostParameters
from ppaas.costmap.inflation_layer import COST_SCALING_FACTOR, INFLATION_RADIUS, ROBOT_RADIUS, inflate
from ppaas.costmap.map_layers import MapLayers, with_causes
from ppaas.kernel_threads import limit_threads
from ppaas.maps.free_space import distance_to_occupied
from ppaas.maps.grid import FREE, OCCUPIED, OCCUPIED_THRESHOLD, UNKNOWN, GridInfo, GridMap
from ppaas.zones.masks import kept_out
from ppaas.zones.zone import NO_ZONES, Zone, ZoneSet


def build_layers(
    grid: GridMap,
    *,
    robot_radius: float = ROBOT_RADIUS,
    inflation_radius: float = INFLATION_RADIUS,
    cost_scaling_factor: float = COST_SCALING_FACTOR,
    lethal_cost_threshold: int = OCCUPIED_THRESHOLD,
    keepout: GridMap | None = None,
    overhead: GridMap | None = None,
    speed: GridMap | None = None,
    zones: ZoneSet = NO_ZONES,
    distance: NDArray[np.float32] | None = None,
    threads: int | None = None,
) -> MapLayers:
    """Return the layers of a map: inflated costmap, distances and masks.

    Parameters
    ----------
    grid : GridMap
        The map.
    robot_radius : float
        Inscribed radius of the robot [m].
    inflation_radius : float
        Distance from obstacles up to which cells have a cost [m].
    cost_scaling_factor : float
        Rate at which costs decay with the distance [1/m].
    lethal_cost_threshold : int
        Occupancy of the map from which a cell is lethal; less occupied cells are free, as with costmap_2d's
        ``trinary_costmap``. Localization uses the default threshold in any case.
    keepout, speed : GridMap, optional
        Masks of Nav2's costmap filters, of any resolution and origin, in the frame of the map. Cells of 100 in the
        keep-out mask are inflated like obstacles.
    overhead : GridMap, optional
        Keep-out mask of `height_mask`, for a map in space; treated like ``keepout``.
    zones : ZoneSet
        Zones of the map. Robots keep out of zones of the kind ``keep_out`` that have no times, as of the masks; for
        zones with times see ``ppaas.costmap.build_layers``.
    distance : (h, w) float32 array, optional
        Distances to the nearest occupied cell [m], if they are known; computed by default.
    threads : int, optional
        Maximum number of threads, where other threads may call kernels at the same time; by default numba's.

    Raises
    ------
    InvalidParameter
        A radius or the factor is negative or not finite.
    """
    barriers = _barriers((keepout, overhead), zones, grid.info)
    with nullcontext(2) if threads is None else limit_threads(threads) as usable:
        to_lethal = distance = distance_to_occupied(grid, serial=usable < 2) if distance is None else distance
        if barriers is not None or lethal_cost_threshold != OCCUPIED_THRESHOLD:
            shut = grid if barriers is None else barred(grid, barriers)
            to_lethal = distance_to_occupied(shut, lethal_cost_threshold, serial=usable < 2)
        costs = inflate(
            to_lethal,
            inscribed_radius=robot_radius,
            inflation_radius=inflation_radius,
            cost_scaling_factor=cost_scaling_factor,
            unknown=grid.data == UNKNOWN,
            serial=usable < 2,
        )
    if barriers is not None:
        raise_costs(costs, barriers.data)
    layers = MapLayers(
        grid, Costmap(costs, grid.info), _read_only(distance),
        keepout=barriers,
        barred_distance=None if to_lethal is distance else to_lethal,
        speed=None if speed is None else sampled(speed, grid.info),
        zones=zones,
        overhead=None if overhead is None else spread(overhead, grid.info),
    )  # fmt: skip
    return with_causes(layers)


def _read_only(distance: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return a read-only view: kernels of localization are compiled for one, since robots share the layers of a map."""
    view = distance.view()
    view.flags.writeable = False
    return view


def _barriers(masks: Sequence[GridMap | None], zones: ZoneSet, info: GridInfo) -> GridMap | None:
    """Return keep-out masks and the zones that robots always keep out of, as one mask; None if there are none."""
    found = [spread(mask, info) for mask in masks if mask is not None]
    kept = kept_out(info, (zone for zone in zones.zones if not zone.rule.times))
    if kept is not None:
        found.append(GridMap(np.where(kept, np.int8(OCCUPIED), np.int8(FREE)), info))
    return GridMap(np.maximum.reduce([mask.data for mask in found]), info) if found else None


def recosted(layers: MapLayers, robot_radius: float, costs: CostParameters) -> Costmap:
    """Return the costmap that the map of these layers has for another radius [m] or other costs, without masks."""
    threshold = costs.lethal_cost_threshold
    usual = threshold == OCCUPIED_THRESHOLD
    data = inflate(
        layers.distance if usual else distance_to_occupied(layers.grid, threshold),
        inscribed_radius=robot_radius,
        inflation_radius=costs.inflation_radius,
        cost_scaling_factor=costs.cost_scaling_factor,
        unknown=layers.grid.data == UNKNOWN,
    )
    return with_causes(replace(layers, costmap=Costmap(data, layers.grid.info), keepout=None)).costmap


def without_unknown(layers: MapLayers, robot_radius: float, costs: CostParameters) -> MapLayers:
    """Return layers in which unknown cells are free, for a robot of a radius [m]; masks and indexes are kept."""
    grid = GridMap(np.where(layers.grid.data == UNKNOWN, np.int8(FREE), layers.grid.data), layers.grid.info)
    data = inflate(
        layers.to_lethal,
        inscribed_radius=robot_radius,
        inflation_radius=costs.inflation_radius,
        cost_scaling_factor=costs.cost_scaling_factor,
        serial=True,  # a planner may call kernels at the same time
    )
    if layers.keepout is not None:
        raise_costs(data, layers.keepout.data)
    return replace(layers, grid=grid, costmap=replace(layers.costmap, data=data))


# -- layers while keep-out zones with times are in force ---------------------------------------------------------------


def with_closed(layers: MapLayers, closed: list[Zone], robot_radius: float, costs: CostParameters) -> MapLayers:
    """Return layers in which robots keep out of some more zones, for a robot of any radius.

    Parameters
    ----------
    layers : MapLayers
        Layers of the map, without these zones.
    closed : list of Zone
        Zones of the kind ``keep_out``, or none.
    robot_radius : float
        Radius of the robot [m].
    costs : CostParameters
        Parameters of its costs, with which the layers were made.
    """
    info = layers.grid.info
    mask, keepout = kept_out(info, closed), layers.keepout
    if mask is not None:
        shut = np.where(mask, np.int8(OCCUPIED), np.int8(FREE))
        keepout = GridMap(shut if keepout is None else np.maximum(shut, keepout.data), info)
    made = build_layers(
        layers.grid,
        robot_radius=robot_radius,
        inflation_radius=costs.inflation_radius,
        cost_scaling_factor=costs.cost_scaling_factor,
        lethal_cost_threshold=costs.lethal_cost_threshold,
        keepout=keepout,
        distance=layers.distance,
    )
    return with_causes(replace(made, speed=layers.speed, zones=layers.zones, overhead=layers.overhead))
