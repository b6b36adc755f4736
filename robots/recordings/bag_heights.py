"""Heights of the robot in a bag: by a barometer, or by an odometry in space."""

from collections import defaultdict
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.buildings.riding.air import height_between
from ppaas.errors import InvalidInput
from robots.recordings.bag import ROS_ENCODINGS, Bag
from robots.recordings.bag_objects import BagObjects, full_type
from robots.recordings.ros_bags import ODOMETRY

PRESSURE = "sensor_msgs/msg/FluidPressure"

STOREY = 1.5
"""Difference of heights in an odometry from which it is one in space [m]."""


class BagHeights(NamedTuple):
    """Heights of a drive.

    Parameters
    ----------
    topic : str
        Topic that they are from.
    stamps, heights : (n,) array
        Times [s], and heights above the first [m].
    """

    topic: str
    stamps: NDArray[np.float64]
    heights: NDArray[np.float64]


def heights_of(path: Path, topic: str | None = None) -> BagHeights:
    """Return the heights in a bag: by its barometer, or else by an odometry whose height changes.

    Parameters
    ----------
    path : Path
        A bag of ROS 1 or 2.
    topic : str, optional
        Topic with the heights; by default the barometer with the most messages, or else the odometry.

    Raises
    ------
    InvalidInput
        The bag cannot be read, a pressure is none of the air, or there are no heights.
    """
    objects, found = BagObjects(), defaultdict[str, list[tuple[float, float]]](list)
    kinds: dict[str, str] = {}
    for message in Bag(path).messages():
        kind, name = full_type(message.channel.type), message.channel.topic
        is_wanted = kind in (PRESSURE, ODOMETRY) and message.channel.encoding in ROS_ENCODINGS
        if not is_wanted or (topic is not None and name.lstrip("/") != topic.lstrip("/")):
            continue
        if (read := objects.read(message)) is not None:
            stamp = _stamp(read.header) or message.log_time * 1e-9
            value = read.fluid_pressure if kind == PRESSURE else read.pose.pose.position.z
            found[name].append((stamp, float(value)))
            kinds[name] = kind
    for name in sorted(found, key=lambda name: (kinds[name] != PRESSURE, -len(found[name]))):
        stamps, values = np.array(found[name]).T
        heights = _risen(values, name) if kinds[name] == PRESSURE else values - values[0]
        if kinds[name] == PRESSURE or topic is not None or np.ptp(heights) >= STOREY:
            return BagHeights(name, stamps, heights)
    raise InvalidInput(
        f"{path} has no heights{f' on {topic}' if topic else ''}: floors are found by a barometer "
        "(sensor_msgs/FluidPressure), or an odometry with z"
    )


def _risen(pressures: NDArray[np.float64], topic: str) -> NDArray[np.float64]:
    try:
        return np.array([height_between(pressures[0], pressure) for pressure in pressures])
    except InvalidInput as error:
        raise InvalidInput(f"topic {topic}: {error}") from error


def _stamp(header: Any) -> float:
    """Return the stamp of a header of ROS 1 or ROS 2 [s]."""
    fraction = getattr(header.stamp, "nanosec", None)
    return float(header.stamp.sec) + 1e-9 * float(header.stamp.nsec if fraction is None else fraction)
