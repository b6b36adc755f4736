"""Place of the robot across its restarts and its clone's.

A clone that outlives a restart of its robot must not believe it at its old place, and a new clone, after a long outage,
starts at the ``initial_pose`` of the robot's file although the robot stands elsewhere.
"""

import asyncio
import math
from collections.abc import Iterable, Mapping
from typing import Any

from ppaas.errors import Unavailable
from ppaas.geometry import Pose2D
from ppaas.wire.ros.types import to_json
from robots.bridges.core.parts import Parts
from robots.bridges.core.restarts import RestartWatch, planar

RETRY = 1.0
"""Time after which a clone that could not be reached is informed again that its robot has restarted [s]."""

VARIANCE, VARIANCE_YAW = 0.1, 0.05
"""Variances of a pose that the bridge remembers [m², rad²]."""


class Localization:
    """Sends the clone the pose of the robot, or that it is unknown.

    Parameters
    ----------
    parts : Parts
        Ends of the bridge.
    """

    def __init__(self, parts: Parts) -> None:
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
