"""Place of the robot across its restarts, which its odometry shows, and its clone's.

A clone that outlives a restart of its robot must not believe it at its old place, and a new clone, after a long outage,
starts at the ``initial_pose`` of the robot's file although the robot stands elsewhere.
"""

import asyncio
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from ppaas.errors import Unavailable
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.wire.ros.types import to_json
from robots.bridges.core.parts import BridgeParts

SLACK, FASTEST = 0.5, 3.0
"""Odometry was reset if it jumped by more than `SLACK` [m] plus what `FASTEST` [m/s] allows."""

ORIGIN = 0.05
"""Distance and turn from zero at which odometry counts as just begun [m, rad]."""

SILENCE = 1.0
"""Time without odometry after which a pose at the origin is a new beginning, although it was there before [s]."""

SET_BACK = 1.0
"""Least time by which stamps go back if the clock of a robot starts over [s]."""

TOGETHER = 30.0
"""Longest time between the arrival of a new publisher and a reset of the odometry, if they are one restart [s]."""

MAX_PUBLISHERS = 1000
"""Largest number of publishers that are remembered."""


@dataclass(frozen=True, slots=True)
class _Odometry:
    pose: Pose2D
    stamp: float
    at: float

    def begins_anew(self, before: "_Odometry") -> bool:
        passed, jump = self.at - before.at, self.pose.distance_to(before.pose)
        if jump > SLACK + FASTEST * passed or self.stamp < before.stamp - SET_BACK:
            return True
        at_origin = math.hypot(self.pose.x, self.pose.y) < ORIGIN and abs(self.pose.theta) < ORIGIN
        return at_origin and (passed > SILENCE or jump > ORIGIN)


class RestartWatch:
    """Notices restarts: a new publisher of odometry, and a reset of the odometry.

    Neither alone is a restart. A driver may reset its odometry, and a node that starts again may continue it.
    """

    def __init__(self) -> None:
        self._known: set[str] = set()
        self._last: _Odometry | None = None
        self._arrived: float | None = None
        self._began: float | None = None

    @property
    def pose(self) -> Pose2D | None:
        """Pose of the newest odometry; None before the first."""
        return None if self._last is None else self._last.pose

    def publishers(self, ids: Iterable[str], now: float) -> None:
        """Take the publishers of odometry that are in the graph at the time ``now`` [s]."""
        found = set(ids)
        if found - self._known and self._known:
            self._arrived = now
        if len(self._known) > MAX_PUBLISHERS:
            self._known.clear()
        self._known |= found

    def odometry(self, message: Mapping[str, Any], now: float) -> None:
        """Take an odometry message that arrived at the time ``now`` [s]."""
        stamp = message["header"]["stamp"]
        pose = planar(message["pose"]["pose"], "position", "orientation")
        new = _Odometry(pose, stamp["sec"] + stamp["nanosec"] * 1e-9, now)
        if self._last is not None and new.begins_anew(self._last):
            self._began = now
        self._last = new

    def restarted(self) -> bool:
        """Return whether the robot has restarted; once a restart."""
        if self._arrived is None or self._began is None or abs(self._arrived - self._began) > TOGETHER:
            return False
        self._arrived = self._began = None
        return True


def planar(values: Mapping[str, Any], position: str, orientation: str) -> Pose2D:
    """Return a pose or a transform of ROS, given as a dict with these keys, as a pose in the plane."""
    place, turn = values[position], values[orientation]
    yaw = 2.0 * math.atan2(turn["z"], turn["w"])
    return Pose2D(place["x"], place["y"], wrap_angle(yaw))


RETRY = 1.0
"""Time after which a clone that could not be reached is informed again that its robot has restarted [s]."""

VARIANCE, VARIANCE_YAW = 0.1, 0.05
"""Variances of a pose that the bridge remembers [m², rad²]."""


class RobotLocalization:
    """Sends the clone the pose of the robot, or that it is unknown.

    Parameters
    ----------
    parts : BridgeParts
        Ends of the bridge.
    """

    def __init__(self, parts: BridgeParts) -> None:
        self._parts = parts
        self._watch, self._restarts = RestartWatch(), 0

    def publishers(self, ids: Iterable[str]) -> None:
        """Take the publishers of odometry that are in the graph now."""
        self._watch.publishers(ids, self._parts.clock())
        self._note_restart()

    def odometry(self, message: Mapping[str, Any], now: float) -> None:
        """Take an odometry message that arrived at the time ``now`` [s]."""
        self._watch.odometry(message, now)
        self._note_restart()

    async def renew(self) -> None:
        """Send a new clone the pose of the robot, if an earlier one knew it."""
        in_map, odometry = self._parts.frames.in_map, self._watch.pose
        if in_map is None or odometry is None:
            return
        pose = planar(in_map, "translation", "rotation") @ odometry
        self._parts.notices.info("another session began: the clone is told where the robot stands")
        await self._parts.link.publish("initialpose", to_json(_initial_pose(pose)))

    def _note_restart(self) -> None:
        if not self._watch.restarted():
            return
        self._restarts += 1
        self._parts.frames.in_map = None
        self._parts.notices.info(
            f"the robot has restarted (restart {self._restarts}): the clone searches the whole map for it"
        )
        self._parts.start(self._localize_anew())

    async def _localize_anew(self) -> None:
        while True:
            try:
                await self._parts.link.call("global_localization", "std_srvs/srv/Empty", b"{}")
            except Unavailable:
                await asyncio.sleep(RETRY)
            else:
                return


def _initial_pose(pose: Pose2D) -> dict[str, Any]:
    covariance = [0.0] * 36
    covariance[0] = covariance[7] = VARIANCE
    covariance[35] = VARIANCE_YAW
    orientation = {"z": math.sin(pose.theta / 2.0), "w": math.cos(pose.theta / 2.0)}
    placed = {"position": {"x": pose.x, "y": pose.y}, "orientation": orientation}
    return {"header": {"frame_id": "map"}, "pose": {"pose": placed, "covariance": covariance}}
