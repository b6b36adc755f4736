"""Speed limits of a robot: from operators (``nav2_msgs/SpeedLimit``), and by place from a mask and from zones."""

import math
from collections.abc import Callable, Sequence
from functools import reduce
from typing import Protocol

import numpy as np

from ppaas.controllers.base import NO_LIMIT, SpeedLimit
from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.geometry import Pose2D
from ppaas.maps.grid import FREE, OCCUPIED, GridMap
from ppaas.messages import nav2_msgs
from ppaas.nodes.map_server.costmap_filters import SPEED_FILTER, SpeedFilterParameters


def limit_of(message: nav2_msgs.SpeedLimit) -> SpeedLimit:
    """Return the limit of a message; 0 means no limit.

    Raises
    ------
    InvalidInput
        The limit is not finite, negative, or more than 100 %.
    """
    value = message.speed_limit
    if not (math.isfinite(value) and value >= 0.0) or (message.percentage and value > 100.0):
        raise InvalidInput(f"speed_limit must be 0 for none, a speed [m/s], or a percentage up to 100, not {value}")
    if value == 0.0:
        return NO_LIMIT
    return SpeedLimit(part=value / 100.0) if message.percentage else SpeedLimit(speed=value)


def lower_of(one: SpeedLimit, other: SpeedLimit) -> SpeedLimit:
    """Return the limit that satisfies both."""
    return SpeedLimit(min(one.speed, other.speed), min(one.part, other.part))


class LimitsByPlace(Protocol):
    """Speed limits by place."""

    def at(self, pose: Pose2D) -> SpeedLimit:
        """Return the limit at a pose of the robot."""
        ...


def without_limits(_layers: MapLayers, _now: Callable[[], float]) -> Sequence[LimitsByPlace]:
    """Return nothing: there are no speed limits by place."""
    return ()


class SpeedLimits:
    """Speed limit of a robot: the last one from an operator, combined with those by place.

    Parameters
    ----------
    places : sequence of LimitsByPlace
        All of them hold.

    Attributes
    ----------
    received : nav2_msgs.SpeedLimit
        Last limit from an operator.
    """

    def __init__(self, places: Sequence[LimitsByPlace] = ()) -> None:
        self.use_places(places)
        self.take(nav2_msgs.SpeedLimit(0.0))

    def use_places(self, places: Sequence[LimitsByPlace]) -> None:
        """Replace the limits by place."""
        self._places = places

    def take(self, message: nav2_msgs.SpeedLimit) -> None:
        """Set the limit of an operator; raises ``InvalidInput`` as `limit_of` does."""
        self._limit, self.received = limit_of(message), message

    def at(self, pose: Pose2D, goal: float = 0.0) -> SpeedLimit:
        """Return the limit at a pose of the robot, including the goal's [m/s]; 0 if that has none."""
        limit = reduce(lower_of, (place.at(pose) for place in self._places), self._limit)
        return lower_of(limit, SpeedLimit(speed=goal)) if goal > 0.0 else limit


class SpeedFilter:
    """Speed limits from the cells of a mask, as in Nav2's speed filter.

    There is no limit in cells that are 0 or unknown, and outside the mask. (Nav2 keeps the last limit in unknown cells
    and outside, so that the speed allowed depends on where the robot came from.)

    Parameters
    ----------
    mask : GridMap
        In the map frame.
    parameters : SpeedFilterParameters
        Conversion of cells into limits.

    Raises
    ------
    InvalidParameter
        The limit of a cell is not above 0, or is more than 100 %.
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
                f"{SPEED_FILTER}: cells with value {value} in mask {p.filter_mask!r} give a limit of {limits[value]:g}"
                f"{' %' if percent else ' m/s'}, which must be {'above 0 and at most 100' if percent else 'above 0'}: "
                "change base and multiplier, or the mask; to keep robots out, use keepout_filter"
            )
        self._limits = [
            SpeedLimit(part=limit / 100.0) if percent else SpeedLimit(speed=limit) for limit in limits.tolist()
        ]
        self._limits[FREE] = NO_LIMIT

    def at(self, pose: Pose2D) -> SpeedLimit:
        """Return the limit of the cell of the robot's centre."""
        cell = self._mask.info.cell_of(pose.x, pose.y)
        value = int(self._mask.data[cell]) if cell is not None else FREE
        return self._limits[max(value, FREE)]
