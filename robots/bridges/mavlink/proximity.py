"""Distance sensors of a vehicle as a laser scan, counter-clockwise around its body."""

import math
from typing import Any

from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.nodes.frames import BASE_LINK
from robots.bridges.mavlink.dialect import mavlink

UNKNOWN = 0xFFFF
"""Distance of OBSTACLE_DISTANCE that is not known [cm]."""

SECTORS = 8
"""Number of horizontal directions of DISTANCE_SENSOR, clockwise from forward, which have the numbers from 0 on."""

FRESH = 1.0
"""Age at which a distance of one sensor counts no more [s]."""

Range = float | None


class Proximity:
    """Collects distances, and returns scans.

    A ring of OBSTACLE_DISTANCE is a scan by itself; single sensors are the beams of one. A vehicle that sends both is
    believed by its ring.
    """

    def __init__(self) -> None:
        self._ring_at = -math.inf
        self._single: dict[int, tuple[float, Any]] = {}

    def take(self, message: Any, now: float, stamp: Time) -> LaserScan | None:
        """Take a message that arrived at a time [s]; return the scan that it completes, if any."""
        if message.get_type() == "OBSTACLE_DISTANCE":
            self._ring_at = now
            return ring(message, stamp)
        if not 0 <= message.orientation < SECTORS or now - self._ring_at <= FRESH:
            return None
        before = self._single.get(message.orientation)
        self._single[message.orientation] = now, message
        first = min(self._single)
        if message.orientation != first and before is not None:
            return None  # one scan a round of the sensors
        return self._together(now, stamp)

    def _together(self, now: float, stamp: Time) -> LaserScan:
        ranges: list[Range] = [None] * SECTORS
        fresh = {sector: one for sector, (at, one) in self._single.items() if now - at <= FRESH}
        for sector, one in fresh.items():
            ranges[-sector % SECTORS] = one.current_distance * 1e-2
        least = min(one.min_distance for one in fresh.values()) * 1e-2
        most = max(one.max_distance for one in fresh.values()) * 1e-2
        return _scan(ranges, 0.0, math.tau / SECTORS, (least, most), stamp)


def ring(message: Any, stamp: Time) -> LaserScan | None:
    """Return the scan of an OBSTACLE_DISTANCE; None for one without a sector, or in a frame that turns with nothing."""
    step = message.increment_f or float(message.increment)
    if message.frame not in (mavlink.MAV_FRAME_GLOBAL, mavlink.MAV_FRAME_BODY_FRD) or not 0.1 <= abs(step) <= 360.0:
        return None
    count = min(len(message.distances), int(360.0 / abs(step) + 1e-6))
    ranges: list[Range] = [None if cm == UNKNOWN else cm * 1e-2 for cm in message.distances[:count]]
    start = -math.radians(message.angle_offset)
    if step > 0.0:  # clockwise
        ranges.reverse()
        start -= math.radians((count - 1) * step)
    limits = message.min_distance * 1e-2, message.max_distance * 1e-2
    return _scan(ranges, math.remainder(start, math.tau), math.radians(abs(step)), limits, stamp)


def _scan(ranges: list[Range], start: float, step: float, limits: tuple[float, float], stamp: Time) -> LaserScan:
    return LaserScan(
        Header(stamp=stamp, frame_id=BASE_LINK),
        angle_min=start,
        angle_max=start + (len(ranges) - 1) * step,
        angle_increment=step,
        range_min=limits[0],
        range_max=limits[1],
        ranges=ranges,
    )
