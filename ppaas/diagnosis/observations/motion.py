"""Motion of a robot by its commands and by its odometry, over the same seconds."""

import itertools
import math
from collections import deque

from ppaas.diagnosis.observations.facts import MotionFacts
from ppaas.geometry import wrap_angle
from ppaas.messages.geometry_msgs import Twist
from ppaas.messages.nav_msgs import Odometry

WINDOW = 10.0
"""Time for which commands and poses are kept [s]."""

MOST = 2000
"""Largest number of commands, and of poses, that are kept."""

ARM = 0.2
"""Distance from the centre at which a turn counts as a path [m]."""

LONGEST_COMMAND = 0.5
"""Time for which a command holds without another one [s], as base controllers have it."""

Sample = tuple[float, float, float, float]
"""Time [s], and either x [m], y [m], yaw [rad], or velocities [m/s, m/s, rad/s]."""


class Motion:
    """Commands and odometry of the last `WINDOW` seconds."""

    def __init__(self) -> None:
        self._commands: deque[Sample] = deque(maxlen=MOST)
        self._poses: deque[Sample] = deque(maxlen=MOST)
        self._frames = "", ""

    def command(self, twist: Twist, now: float) -> None:
        """Note a command that arrived at monotonic time ``now`` [s]."""
        self._commands.append((now, twist.linear.x, twist.linear.y, twist.angular.z))

    def odometry(self, message: Odometry, now: float) -> None:
        """Note a message of the odometry; a pose that is not valid is left out."""
        self._frames = message.header.frame_id.lstrip("/"), message.child_frame_id.lstrip("/")
        pose = message.pose.pose.planar()
        if all(map(math.isfinite, (pose.x, pose.y, pose.theta))):
            self._poses.append((now, pose.x, pose.y, pose.theta))

    def facts(self, now: float) -> MotionFacts:
        """Return what was ordered and what was moved until ``now`` [s]."""
        for kept in (self._commands, self._poses):
            while kept and now - kept[0][0] > WINDOW:
                kept.popleft()
        ordered, ordered_turn, ordered_path = _ordered(self._commands, now)
        moved, moved_turn, moved_path, jump = _moved(self._poses)
        return MotionFacts(
            commands=len(self._commands),
            ordered=ordered,
            ordered_turn=ordered_turn,
            ordered_path=ordered_path,
            moved=moved,
            moved_turn=moved_turn,
            moved_path=moved_path,
            parent=self._frames[0],
            child=self._frames[1],
            jump=jump,
        )


def _ordered(commands: deque[Sample], now: float) -> tuple[float, float, float]:
    forward = turn = path = 0.0
    ends = [*(command[0] for command in itertools.islice(commands, 1, None)), now]
    for (at, x, y, yaw_rate), end in zip(commands, ends, strict=False):
        seconds = min(end - at, LONGEST_COMMAND)
        forward += x * seconds
        turn += yaw_rate * seconds
        path += (math.hypot(x, y) + ARM * abs(yaw_rate)) * seconds
    return forward, turn, path


def _moved(poses: deque[Sample]) -> tuple[float, float, float, float]:
    forward = turn = path = jump = 0.0
    for (_, x, y, yaw), (_, next_x, next_y, next_yaw) in itertools.pairwise(poses):
        dx, dy, turned = next_x - x, next_y - y, wrap_angle(next_yaw - yaw)
        forward += dx * math.cos(yaw) + dy * math.sin(yaw)
        turn += turned
        step = math.hypot(dx, dy)
        path += step + ARM * abs(turned)
        jump = max(jump, step)
    return forward, turn, path, jump
