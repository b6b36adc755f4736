"""Choice of the roadmap of a map: along its lanes, or over all of it."""

from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import NDArray

from ppaas.fleet.lanes.drawing import lines_in
from ppaas.fleet.lanes.roadmap import lane_roadmap
from ppaas.fleet.lattice_roadmap import lattice_roadmap
from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.fleet.robot_sizes import RobotSizes
from ppaas.maps.grid import GridInfo
from ppaas.planners.watch import proceed
from ppaas.zones.zone import Zone


def roadmap_on(
    to_lethal: NDArray[np.float32],
    info: GridInfo,
    zones: Iterable[Zone],
    sizes: RobotSizes,
    check: Callable[[], None] = proceed,
) -> MetricRoadmap:
    """Return the roadmap along the lanes among the zones of a map, or over all of the map if there are none.

    Parameters
    ----------
    to_lethal : (h, w) float32 array
        Distance from each map cell to the nearest lethal cell [m], 0 in unknown cells (`clearance_of`).
    info : GridInfo
        Geometry of the map.
    zones : iterable of Zone
        Rules of others are not applied (`rules_on`).
    sizes : RobotSizes
    check : callable
        Called every now and then; ends the work by raising.

    Raises
    ------
    InvalidInput
        No robot of that size fits on the map or on a lane, or lanes are too near to each other.
    """
    lines = lines_in(zones)
    if lines:
        return lane_roadmap(lines, to_lethal, info, sizes)
    return lattice_roadmap(to_lethal, info, sizes, check)
