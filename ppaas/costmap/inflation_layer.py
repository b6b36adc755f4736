"""The inflation layer of costmap_2d: what it costs to be near an obstacle."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.kernels.inflation import inflate_parallel, inflate_serial
from ppaas.errors import InvalidMap, InvalidParameter

ROBOT_RADIUS = 0.18
"""Of a Turtlebot [m]."""

INFLATION_RADIUS = 0.55
COST_SCALING_FACTOR = 10.0

_PARALLEL_FROM = 1 << 17
"""Cells from which waking other threads pays."""


def check_inflation(inscribed_radius: float, inflation_radius: float, cost_scaling_factor: float) -> None:
    """Raise ``InvalidParameter``, naming the one that is negative or not finite."""
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
) -> NDArray[np.uint8]:
    """Return the cost of each cell by its distance to the nearest obstacle.

    The rule of ``inflation_layer.h``: 254 at distance 0, 253 up to the inscribed radius, then
    252 · exp(−factor · (distance − inscribed radius)) rounded down, and 0 beyond the inflation radius.

    Parameters
    ----------
    distance : (height, width) float32 array
        As ``distance_to_occupied`` gives it [m].
    inscribed_radius, inflation_radius : float
        [m].
    cost_scaling_factor : float
        [1/m].
    unknown : (height, width) bool array, optional
        Cells of which the map knows nothing: 255 unless inflated to 253 or more.

    Returns
    -------
    (height, width) uint8 array
        Values of costmap_2d.

    Notes
    -----
    An inflation radius below the inscribed one would hide collisions; so up to the inscribed radius it is always 253.

    Raises
    ------
    InvalidParameter
        A radius or the factor is negative or not finite.
    InvalidMap
        Arrays of the wrong type or of different shapes.
    """
    check_inflation(inscribed_radius, inflation_radius, cost_scaling_factor)
    if unknown is None:
        unknown = np.zeros(distance.shape, np.bool_)
    if distance.ndim != 2 or distance.dtype != np.float32 or unknown.shape != distance.shape:
        raise InvalidMap(f"expected float32 distances of {unknown.shape}, got {distance.dtype} of {distance.shape}")
    kernel = inflate_parallel if distance.size >= _PARALLEL_FROM else inflate_serial
    return kernel(
        np.ascontiguousarray(distance),
        np.ascontiguousarray(unknown).view(np.uint8),
        inscribed_radius,
        inflation_radius,
        cost_scaling_factor,
    )
