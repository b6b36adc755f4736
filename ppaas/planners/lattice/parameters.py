"""The parameters of the kinematic planner, with the names and the defaults of Nav2's SmacPlannerHybrid."""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidParameter
from ppaas.geometry import convex_outline
from ppaas.parameters import check_scalar

DUBIN, REEDS_SHEPP = "DUBIN", "REEDS_SHEPP"

_AT_LEAST_ONE = ("reverse_penalty", "non_straight_penalty", "analytic_expansion_ratio")
_ABOVE_ZERO = ("max_planning_time", "minimum_turning_radius")
MOST_BINS = 720


@dataclass(frozen=True, slots=True, kw_only=True)
class LatticeParameters:
    """What can be set.

    Parameters
    ----------
    allow_unknown : bool
        Whether paths may lead through unknown cells, which cost a little more than the worst known ones.
    tolerance : float
        If the goal is blocked, the free cell nearest to it within this distance will do [m], or within that of the
        request where it is larger.
    max_iterations : int
        Most nodes that are worked off; −1 for as many as it takes.
    max_planning_time : float
        Most time, or that of the request where it is less [s].
    motion_model_for_search : str
        ``DUBIN`` drives forward only, ``REEDS_SHEPP`` backward as well.
    minimum_turning_radius : float
        Of the circle on which the robot turns most sharply [m]; a cell at least.
    angle_quantization_bins : int
        Bins of headings, from 8 to `MOST_BINS`: a turn of the search is a few bins.
    allow_primitive_interpolation : bool
        Whether the search also turns by less than its sharpest turn, down to a bin.
    analytic_expansion_ratio : float
        The curve to the goal is tried each time so many nodes were worked off as the distance to the goal holds
        this many cells.
    analytic_expansion_max_length : float
        Longest curve to the goal that is tried [m]; five turning radii at least.
    reverse_penalty, non_straight_penalty : float
        What a length weighs that is driven backward, and in a turn; 1 at least.
    change_penalty : float
        What a turn weighs more that follows a straight piece or a turn to the other side.
    cost_penalty : float
        What a cell of cost 252 weighs more than a free one; from 0 to 4.
    retrospective_penalty : float
        By how much less a length weighs in the search than in its estimates, which draws it on; below 1.
    smooth_path : bool
        Whether the path is made cheaper by curves that leave out bends of it.
    footprint : sequence of pairs
        Corners of the robot's outline, x, y in its frame [m]; the smallest convex outline around them counts. No
        part of it touches a lethal cell. Without it the robot is its centre, which keeps out of inscribed cells.

    Raises
    ------
    InvalidParameter
        One is of the wrong type or out of range; the text names it.
    """

    allow_unknown: bool = True
    tolerance: float = 0.25
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
    footprint: Sequence[Sequence[float]] = ()

    def __post_init__(self) -> None:
        for field in fields(self):
            if field.type in (bool, int, float):
                value = getattr(self, field.name)
                check_scalar(field.name, value, field.type)
                _check_range(field.name, value)
        if self.motion_model_for_search not in (DUBIN, REEDS_SHEPP):
            raise InvalidParameter(
                f"motion_model_for_search is {DUBIN} or {REEDS_SHEPP}, not {self.motion_model_for_search!r}"
            )
        if not 8 <= self.angle_quantization_bins <= MOST_BINS:
            raise InvalidParameter(f"angle_quantization_bins must be from 8 to {MOST_BINS}")
        if self.cost_penalty > 4.0 or self.retrospective_penalty >= 1.0:
            raise InvalidParameter("cost_penalty must be 4 at most, and retrospective_penalty below 1")
        self.outline()

    def outline(self) -> NDArray[np.float64]:
        """Return the (n, 2) corners of the convex outline of the footprint, counter-clockwise [m]; none without one."""
        if not len(self.footprint):
            return np.empty((0, 2))
        try:
            corners = np.asarray(self.footprint, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise InvalidParameter(f"footprint must be a list of corners x, y [m]: {error}") from error
        if corners.ndim != 2 or corners.shape[1] != 2 or len(corners) < 3 or not np.isfinite(corners).all():
            raise InvalidParameter("footprint must be a list of three corners x, y [m] or more")
        return convex_outline(corners)


def _check_range(name: str, value: float) -> None:
    least = 1.0 if name in _AT_LEAST_ONE else 0.0
    if name != "max_iterations" and (value < least or (name in _ABOVE_ZERO and value == 0.0)):
        raise InvalidParameter(
            f"{name} must be {'above' if name in _ABOVE_ZERO else 'at least'} {least:g}, not {value}"
        )
