"""Parameters of the kinematic planner, with the names and defaults of Nav2's SmacPlannerHybrid."""

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidParameter
from ppaas.footprints import check_corners
from ppaas.geometry import convex_outline
from ppaas.parameters import Parameters, check_numbers

DUBIN, REEDS_SHEPP = "DUBIN", "REEDS_SHEPP"

_AT_LEAST_ONE = ("reverse_penalty", "non_straight_penalty", "analytic_expansion_ratio")
_ABOVE_ZERO = ("max_planning_time", "minimum_turning_radius")
MAX_BINS = 720
"""Largest number of heading bins: half a degree each."""


class LatticeParameters(Parameters, frozen=True, kw_only=True):
    """Parameters of the planner ``lattice``.

    Parameters
    ----------
    allow_unknown : bool
        Whether paths may cross unknown cells, which cost slightly more than the most expensive known ones.
    tolerance : float
        If the goal is blocked, the nearest free cell within this distance replaces it [m]. The larger of this and the
        request's tolerance is used.
    max_iterations : int
        Maximum number of expanded nodes; −1 for no limit.
    max_planning_time : float
        Time limit [s]. The smaller of this and the request's timeout is used.
    motion_model_for_search : str
        ``DUBIN`` drives forward only, ``REEDS_SHEPP`` also backward.
    minimum_turning_radius : float
        Radius of the sharpest turn [m]; at least the size of a cell is used.
    angle_quantization_bins : int
        Number of heading bins, from 8 to `MAX_BINS`. A motion of the search turns by a few bins.
    allow_primitive_interpolation : bool
        Whether the search also uses gentler turns than the sharpest one, down to one bin.
    analytic_expansion_ratio : float
        The number of nodes expanded between two attempts of the analytic curve to the goal is the distance to the goal
        [cells] divided by this ratio.
    analytic_expansion_max_length : float
        Length limit of the analytic curve to the goal [m]; at least five turning radii are used.
    reverse_penalty, non_straight_penalty : float
        Factors on the length driven in reverse, and in a turn; at least 1.
    change_penalty : float
        Added to the factor of a turn that follows a straight piece or a turn to the other side.
    cost_penalty : float
        Additional weight of a cell of cost 252 over one of cost 0, from 0 to 4.
    retrospective_penalty : float
        Amount by which the search reduces the weight of driven lengths relative to its estimates, which makes it prefer
        nodes near the goal; below 1.
    smooth_path : bool
        Whether to shorten the path by curves that cut its bends.
    footprint : tuple of (x, y)
        Corners of the robot's outline in its frame [m]; its convex hull is used. No part of it touches a lethal
        cell. Without a footprint the robot is a point, which keeps out of inscribed cells.

    Raises
    ------
    InvalidParameter
        A number is not finite, or a parameter is out of range; the text names it.
    """

    allow_unknown: bool = True
    tolerance: float = 0.0
    max_iterations: int = 1_000_000
    max_planning_time: float = 5.0
    motion_model_for_search: str = DUBIN
    minimum_turning_radius: float = 0.4
    angle_quantization_bins: int = 72
    allow_primitive_interpolation: bool = False
    analytic_expansion_ratio: float = 3.5
    analytic_expansion_max_length: float = 3.0
    reverse_penalty: float = 2.0
    non_straight_penalty: float = 1.2
    change_penalty: float = 0.0
    cost_penalty: float = 2.0
    retrospective_penalty: float = 0.015
    smooth_path: bool = True
    footprint: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        """Check the ranges."""
        for name in _AT_LEAST_ONE:
            if getattr(self, name) < 1.0:
                raise InvalidParameter(f"{name} must be at least 1, not {getattr(self, name)}")
        check_numbers(self, positive=_ABOVE_ZERO, signed=("max_iterations",))
        if self.motion_model_for_search not in (DUBIN, REEDS_SHEPP):
            raise InvalidParameter(
                f"motion_model_for_search must be {DUBIN} or {REEDS_SHEPP}, not {self.motion_model_for_search!r}"
            )
        if not 8 <= self.angle_quantization_bins <= MAX_BINS:
            raise InvalidParameter(
                f"angle_quantization_bins must be from 8 to {MAX_BINS}, not {self.angle_quantization_bins}"
            )
        if self.cost_penalty > 4.0:
            raise InvalidParameter(f"cost_penalty must be at most 4, not {self.cost_penalty}")
        if self.retrospective_penalty >= 1.0:
            raise InvalidParameter(f"retrospective_penalty must be below 1, not {self.retrospective_penalty}")
        self.outline()

    def outline(self) -> NDArray[np.float64]:
        """Return the (n, 2) corners of the convex hull of the footprint, counter-clockwise [m]; empty without one."""
        if not self.footprint:
            return np.empty((0, 2))
        check_corners(self.footprint)
        return convex_outline(self.footprint)
