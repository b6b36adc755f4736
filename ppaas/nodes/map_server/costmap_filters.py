"""Parameters of costmap filters, named as in Nav2. A mask is a map, given by its id."""

import math
from collections.abc import Mapping
from typing import Any, Literal

from ppaas.errors import InvalidParameter
from ppaas.parameters import Parameters, read_parameters

KEEPOUT_FILTER = "keepout_filter"
SPEED_FILTER = "speed_filter"


class KeepoutFilterParameters(Parameters, frozen=True):
    """Parameters of the keepout filter.

    Parameters
    ----------
    enabled : bool
        Whether the filter is active.
    filter_mask : str
        Id of a map. The robot keeps out of cells with value 100; cells from 1 to 99 cost more the higher the value.
        Empty for no filter.
    """

    enabled: bool = True
    filter_mask: str = ""

    @property
    def wanted(self) -> str:
        """Id of the active mask; empty for none."""
        return self.filter_mask if self.enabled else ""


class SpeedFilterParameters(KeepoutFilterParameters, frozen=True):
    """Parameters of the speed filter. In a cell of the mask that is not 0, the limit is ``base + multiplier * cell``.

    Parameters
    ----------
    enabled, filter_mask
        As in the keepout filter.
    type : {1, 2}
        As in ``nav2_msgs/CostmapFilterInfo``: limits are percentages of ``max_vel_x`` (1) or speeds (2).
    base, multiplier : float
        Coefficients of the limit [%] or [m/s].
    """

    type: Literal[1, 2] = 1
    base: float = 0.0
    multiplier: float = 1.0

    def __post_init__(self) -> None:
        """Check the ranges."""
        for name in ("base", "multiplier"):
            if not math.isfinite(getattr(self, name)):
                raise InvalidParameter(f"{name} must be finite, not {getattr(self, name)}")


def filter_masks(parameters: Mapping[str, Any]) -> dict[str, str]:
    """Return the ids of the active masks in a robot's parameters, by the names of their filters.

    Raises
    ------
    InvalidParameter
        The parameters of a filter are invalid.
    """
    keepout = read_parameters(KeepoutFilterParameters, KEEPOUT_FILTER, parameters.get(KEEPOUT_FILTER, {}))
    speed = read_parameters(SpeedFilterParameters, SPEED_FILTER, parameters.get(SPEED_FILTER, {}))
    wanted = {KEEPOUT_FILTER: keepout.wanted, SPEED_FILTER: speed.wanted}
    return {name: mask for name, mask in wanted.items() if mask}


def check_no_masks(parameters: Mapping[str, Any]) -> None:
    """Check that a robot that makes a new map has no masks: the frame of its map is another.

    Raises
    ------
    InvalidParameter
        It has one, or the parameters of a filter are invalid.
    """
    for name, mask in filter_masks(parameters).items():
        raise InvalidParameter(
            f"{name}: a robot that makes a new map cannot have the mask {mask!r}, which is in another frame: "
            f"remove it, or set 'enabled' of {name} to false, until the map is published"
        )
