"""Parameters of costmap filters, with the names of Nav2: masks are maps, named by their ids."""

import math
from collections.abc import Mapping
from typing import Any, Literal

from ppaas.errors import InvalidParameter
from ppaas.parameters import Parameters, read_parameters

KEEPOUT_FILTER = "keepout_filter"
SPEED_FILTER = "speed_filter"


class KeepoutFilterParameters(Parameters, frozen=True):
    """Of the keep-out filter.

    Parameters
    ----------
    enabled : bool
        Whether the mask counts.
    filter_mask : str
        Id of a map: the robot keeps out of its cells of 100, and those of 1 to 99 are the dearer the higher. Without it
        there is no filter.
    """

    enabled: bool = True
    filter_mask: str = ""

    @property
    def wanted(self) -> str:
        """Id of the mask that counts; empty for none."""
        return self.filter_mask if self.enabled else ""


class SpeedFilterParameters(KeepoutFilterParameters, frozen=True):
    """Of the speed filter: where a cell of the mask is not 0, the limit is ``base + multiplier * cell``.

    Parameters
    ----------
    enabled, filter_mask
        As of the keep-out filter.
    type : {1, 2}
        As in ``nav2_msgs/CostmapFilterInfo``: limits are percentages of the fastest (1) or speeds in m/s (2).
    base, multiplier : float
        [%] or [m/s].
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
    """Return the ids of the masks that a robot's parameters want, by the names of their filters.

    Raises
    ------
    InvalidParameter
        The parameters of a filter are none.
    """
    keepout = read_parameters(KeepoutFilterParameters, KEEPOUT_FILTER, parameters.get(KEEPOUT_FILTER, {}))
    speed = read_parameters(SpeedFilterParameters, SPEED_FILTER, parameters.get(SPEED_FILTER, {}))
    wanted = {KEEPOUT_FILTER: keepout.wanted, SPEED_FILTER: speed.wanted}
    return {name: mask for name, mask in wanted.items() if mask}
