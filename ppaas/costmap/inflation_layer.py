"""Inflation layer of costmap_2d: costs near obstacles."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.global_parameters import COST_SCALING_FACTOR, INFLATION_RADIUS
from ppaas.costmap.kernels.inflation import inflate_parallel, inflate_serial
from ppaas.errors import InvalidMap, InvalidParameter

__all__ = ["COST_SCALING_FACTOR", "INFLATION_RADIUS", "ROBOT_RADIUS", "check_inflation", "inflate"]

ROBOT_RADIUS = 0.18
"""Radius of a Turtlebot 2 [m]."""

_PARALLEL_FROM = 1 << 17
"""Number of cells from which several threads are faster than one."""


def check_inflation(inscribed_radius: float, inflation_radius: float, cost_scaling_factor: float) -> None:
    """Raise ``InvalidParameter`` if a radius or the factor is negative or not finite."""
    for name, value in (
        ("inscribed_radius", inscribed_radius),
        ("inflation_radius", inflation_radius),
        ("cost_scaling_factor", cost_scaling_factor),
    ):
        if not (math.isfinite(value) and value >= 0.0):
            raise InvalidParameter(f"{name} must be finite and not negative, not {value}")


def inflate(
    distance: NDArray[np.float32],
    *,
    inscribed_radius: float,
    inflation_radius: float = INFLATION_RADIUS,
    cost_scaling_factor: float = COST_SCALING_FACTOR,
    unknown: NDArray[np.bool_] | None = None,
    serial: bool = False,
) -> NDArray[np.uint8]:
    """Return the cost of each cell from its distance to the nearest obstacle.

    The cost is the same as in ``inflation_layer.h``: 254 at distance 0, 253 up to the inscribed radius, then
    252 · exp(−factor · (distance − inscribed radius)) rounded down, and 0 beyond the inflation radius.

    Parameters
    ----------
    distance : (height, width) float32 array
        Distances as returned by ``distance_to_occupied`` [m].
    inscribed_radius : float
        Inscribed radius of the robot [m].
    inflation_radius : float
        Distance from obstacles up to which cells have a cost [m].
    cost_scaling_factor : float
        Rate at which costs decay with the distance [1/m].
    unknown : (height, width) bool array, optional
        Unknown cells of the map: their cost is 255 unless it is 253 or 254 by their distance.
    serial : bool
        Whether to use one thread only.

    Returns
    -------
    (height, width) uint8 array
        Values of costmap_2d.

    Notes
    -----
    Up to the inscribed radius the cost is 253 even if the inflation radius is smaller, which would hide collisions.

    Raises
    ------
    InvalidParameter
        A radius or the factor is negative or not finite.
    InvalidMap
        The arrays have the wrong type or different shapes.
    """
    check_inflation(inscribed_radius, inflation_radius, cost_scaling_factor)
    if unknown is None:
        unknown = np.zeros(distance.shape, np.bool_)
    if distance.ndim != 2 or distance.dtype != np.float32 or unknown.shape != distance.shape:
        raise InvalidMap(
            f"expected float32 distances of shape {unknown.shape}, not {distance.dtype} of shape {distance.shape}"
        )
    kernel = inflate_parallel if distance.size >= _PARALLEL_FROM and not serial else inflate_serial
    return kernel(
        np.ascontiguousarray(distance),
        np.ascontiguousarray(unknown).view(np.uint8),
        inscribed_radius,
        inflation_radius,
        cost_scaling_factor,
    )
