"""Ends of a bridge, which all its parts share."""

from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from typing import Any

from ppaas.clock import Clock
from robots.bridges.core.cloud_link import CloudLink
from robots.bridges.core.frames import Frames
from robots.bridges.core.notices import Notices
from robots.bridges.core.robot_time import RobotTime
from robots.bridges.core.transport import Transport


@dataclass(frozen=True, slots=True)
class Parts:
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
