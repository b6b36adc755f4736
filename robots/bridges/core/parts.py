"""Ends of a bridge, which all its parts share, and the clock of the robot.

The clock follows the stamps of the robot's odometry: stamps of what the bridge sends are in the robot's time.
"""

from collections.abc import Callable, Coroutine, Mapping
from dataclasses import dataclass
from typing import Any

from ppaas.clock import Clock
from robots.bridges.core.cloud_link import CloudLink
from robots.bridges.core.frames import Frames
from robots.bridges.core.notices import Notices
from robots.bridges.core.transport import Transport


class RobotTime:
    """Estimate of the robot's clock.

    Parameters
    ----------
    clock : callable
        Monotonic clock [s].
    epoch : callable
        Clock of this computer [s since the epoch], for as long as the robot's is unknown.
    """

    def __init__(self, clock: Clock, epoch: Clock) -> None:
        self._clock, self._epoch = clock, epoch
        self._stamp: float | None = None
        self._at = 0.0

    def heard(self, stamp: Mapping[str, int], now: float) -> None:
        """Take a stamp of the robot that arrived at the time ``now`` [s]; zero is none."""
        seconds = stamp["sec"] + stamp["nanosec"] * 1e-9
        if seconds:
            self._stamp, self._at = seconds, now

    def now(self) -> dict[str, int]:
        """Return the time of the robot as a stamp."""
        seconds = self._epoch() if self._stamp is None else self._stamp + self._clock() - self._at
        return {"sec": int(seconds), "nanosec": int(seconds % 1.0 * 1e9)}


@dataclass(frozen=True, slots=True)
class BridgeParts:
    """Ends of a bridge, and its knowledge of the robot.

    Parameters
    ----------
    transport : Transport
        The robot.
    link : CloudLink
        The cloud.
    frames : Frames
        Frames of the robot.
    time : RobotTime
        Clock of the robot.
    notices : Notices
        Log.
    clock : callable
        Monotonic clock [s].
    start : callable
        Starts a coroutine in the background.
    """

    transport: Transport
    link: CloudLink
    frames: Frames
    time: RobotTime
    notices: Notices
    clock: Clock
    start: Callable[[Coroutine[Any, Any, None]], None]
