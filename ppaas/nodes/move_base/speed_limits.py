"""How fast a robot may drive: by what operators say (``nav2_msgs/SpeedLimit``), and by where it is (a mask)."""

import math

import numpy as np

from ppaas.controllers.base import NO_LIMIT, SpeedLimit
from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.geometry import Pose2D
from ppaas.maps.grid import FREE, OCCUPIED, GridMap
from ppaas.messages import nav2_msgs
from ppaas.nodes.map_server.costmap_filters import SPEED_FILTER, SpeedFilterParameters


def limit_of(message: nav2_msgs.SpeedLimit) -> SpeedLimit:
    """Return what a message says; 0 is no limit.

    Raises
    ------
    InvalidInput
        Not finite, negative, or more than 100 %.
    """
    value = message.speed_limit
    if not (math.isfinite(value) and value >= 0.0) or (message.percentage and value > 100.0):
        raise InvalidInput(f"a speed_limit is 0 for none, a speed [m/s], or a percentage up to 100, not {value}")
    if value == 0.0:
        return NO_LIMIT
    return SpeedLimit(part=value / 100.0) if message.percentage else SpeedLimit(speed=value)


def lower_of(one: SpeedLimit, other: SpeedLimit) -> SpeedLimit:
    """Return the limit that keeps both."""
    return SpeedLimit(min(one.speed, other.speed), min(one.part, other.part))


class SpeedLimits:
    """How fast a robot may drive: by what an operator said last, and by where it is.

    Parameters
    ----------
    mask : SpeedFilter, optional
        How fast where.

    Attributes
    ----------
    told : nav2_msgs.SpeedLimit
        By an operator.
    """

    def __init__(self, mask: "SpeedFilter | None" = None) -> None:
        self._mask = mask
        self.take(nav2_msgs.SpeedLimit(0.0))

    def take(self, message: nav2_msgs.SpeedLimit) -> None:
        """Take what an operator says; ``InvalidInput`` as `limit_of`."""
        self._limit, self.told = limit_of(message), message

    def at(self, pose: Pose2D) -> SpeedLimit:
        """Return the limit that counts where the robot is."""
        return self._limit if self._mask is None else lower_of(self._limit, self._mask.at(pose))


class SpeedFilter:
    """The limits of a mask, as Nav2's speed filter makes them of its cells.

    There is none where the mask is 0 or unknown, and beyond it. (Nav2 lets the last one hold in these two cases: then
    how fast a robot may drive depends on where it came from.)

    Parameters
    ----------
    mask : GridMap
        In the frame of the map.
    parameters : SpeedFilterParameters
        How limits are made of its cells.

    Raises
    ------
    InvalidParameter
        A cell of the mask has a limit that is not above 0, or more than 100 %.
    """

    def __init__(self, mask: GridMap, parameters: SpeedFilterParameters) -> None:
        self._mask = mask
        p = parameters
        values = np.arange(OCCUPIED + 1)
        limits = p.base + p.multiplier * values
        percent = p.type == 1
        wrong = np.zeros(256, np.bool_)
        wrong[values] = (limits <= 0.0) | ((limits > 100.0) if percent else False)
        wrong[FREE] = False
        if wrong.any() and (found := wrong[mask.data.view(np.uint8)]).any():
            value = int(mask.data[found][0])
            raise InvalidParameter(
                f"{SPEED_FILTER}: cells of {value} in {p.filter_mask!r} make a limit of {limits[value]:g}"
                f"{' %' if percent else ' m/s'}, which must be {'above 0 and at most 100' if percent else 'above 0'}: "
                "change base and multiplier, or the mask; where no robot is to drive, use a keepout_filter"
            )
        self._limits = [
            SpeedLimit(part=limit / 100.0) if percent else SpeedLimit(speed=limit) for limit in limits.tolist()
        ]
        self._limits[FREE] = NO_LIMIT

    def at(self, pose: Pose2D) -> SpeedLimit:
        """Return the limit where the robot is, by its middle."""
        cell = self._mask.info.cell_of(pose.x, pose.y)
        value = int(self._mask.data[cell]) if cell is not None else FREE
        return self._limits[max(value, FREE)]
