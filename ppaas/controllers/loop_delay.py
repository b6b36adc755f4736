"""Delay of a control loop: the time from a command to the odometry that shows it, over network, base and cloud.

A robot that is driven over a network moves on while its odometry is on the way to the cloud and the command on the way
back. A controller that ignores this corrects errors twice: with 0.3 s the robot swings around its path and never
comes to rest at a goal. So the delay is measured, and the controller gets the pose and the velocity that the robot will
have when the command arrives (O. J. M. Smith, *Closer Control of Loops with Dead Time*, 1957).
"""

import math
from collections import deque

from ppaas.controllers.base import Velocity
from ppaas.controllers.motion import advance
from ppaas.geometry import Pose2D

STEP = 0.05
"""Resolution of the delay [s]."""

MOST = 1.2
"""Longest delay that is compensated [s]."""

FORGET = 0.99
"""Factor by which earlier errors count less with each odometry message: with 20 a second, they halve in 3.5 s."""

BETTER = 0.8
"""Factor by which the errors of another delay must be smaller to replace the present one."""

LEAST_ERROR = 0.002
"""Sum of errors of the present delay below which it is kept [(m/s)²]."""

TURN_SCALE = 3.0
"""Turning speed whose error weighs as much as a speed of 1 m/s [rad/s]."""

SLACK, SLACK_OF_DELAY = 0.15, 0.2
"""Error of the velocity up to which the base follows its commands [m/s], and what a second of delay adds to it."""

DRIFT = 1e-4
"""Time by which the clock of the robot may drift from one odometry message to the next [s]."""

RESET = 5.0
"""Change of the difference between both clocks that counts as a new clock, as does a stamp that goes back [s]."""


class LoopDelay:
    """Measures the delay of a control loop, and predicts the motion of the robot by it.

    The velocities of odometry are compared with the commands of some time before, for each delay up to `MOST`; the one
    that explains them best is the delay of the loop. Only changes of commands show it, so it is measured while the
    robot starts, stops and turns, and kept in between. Jitter of the uplink is removed by the stamps of odometry, which
    may be from any clock.

    Attributes
    ----------
    seconds : float
        The delay [s]: from the publication of a command to the arrival of the odometry that shows it, without jitter.
    """

    def __init__(self) -> None:
        # Before its first command the robot stands.
        self._commands: deque[tuple[float, Velocity]] = deque([(-math.inf, Velocity())])
        self._errors = [0.0] * (round(MOST / STEP) + 1)
        self._chosen = 0
        self._stamp, self._behind = -math.inf, math.inf
        self._measured_at = -math.inf
        self._follows = False

    @property
    def seconds(self) -> float:  # noqa: D102 - an attribute, see above
        return self._chosen * STEP

    def command(self, now: float, velocity: Velocity) -> None:
        """Take a command that is published at ``now`` [s]."""
        # Only changes of commands show the delay.
        if velocity != self._commands[-1][1]:
            self._commands.append((now, velocity))

    def measure(self, now: float, velocity: Velocity, stamp: float = 0.0) -> None:
        """Take a velocity by odometry that arrives at ``now``, and was measured at ``stamp`` [s], 0 if unknown."""
        at = self._measured_at = self._without_jitter(now, stamp)
        commands = self._commands
        # One command older than the longest delay stays: it is in force until the next one.
        while len(commands) > 1 and commands[1][0] <= at - MOST:
            commands.popleft()
        if len(commands) > 1:
            self._compare(at, velocity)
        slack = SLACK + SLACK_OF_DELAY * self.seconds
        self._follows = _error(self._at(at - self.seconds), velocity) <= slack * slack

    def _without_jitter(self, now: float, stamp: float) -> float:
        """Return when the message would have arrived without jitter: as late after its stamp as the fastest did."""
        if stamp == 0.0:
            return now
        behind = now - stamp
        if stamp < self._stamp or abs(behind - self._behind) > RESET:
            self._behind = behind
        self._stamp, self._behind = stamp, min(self._behind + DRIFT, behind)
        return max(stamp + self._behind, self._measured_at)

    def _compare(self, at: float, velocity: Velocity) -> None:
        """Add the errors of a velocity for each delay, from the shortest; choose the best delay."""
        errors, commands = self._errors, self._commands
        place = len(commands) - 1
        for number in range(len(errors)):
            while place and commands[place][0] > at - number * STEP:
                place -= 1
            errors[number] = FORGET * errors[number] + _error(commands[place][1], velocity)
        best = min(errors)
        if errors[self._chosen] > LEAST_ERROR and best < BETTER * errors[self._chosen]:
            self._chosen = errors.index(best)

    def _at(self, time: float) -> Velocity:
        return next((velocity for begin, velocity in reversed(self._commands) if begin <= time), Velocity())

    def ahead(self, now: float, pose: Pose2D, velocity: Velocity, known: float = 0.0) -> tuple[Pose2D, Velocity]:
        """Return pose and velocity at the time when a command of ``now`` takes effect.

        Parameters
        ----------
        now : float
            Time [s].
        pose : Pose2D
            Pose by the last odometry.
        velocity : Velocity
            Velocity by the last odometry. If it does not follow the commands, as while somebody holds the robot, the
            robot is where it was measured.
        known : float
            Delay that the controller takes into account itself [s]; the prediction ends so much earlier.
        """
        begin, end = self._measured_at - self.seconds, now - known
        if not self._follows or end <= begin or end - begin > 2.0 * MOST:
            return pose, velocity
        for (since, commanded), until in zip(self._commands, [*self._ends(), end], strict=True):
            seconds = min(until, end) - max(since, begin)
            if seconds > 0.0:
                pose, velocity = advance(pose, commanded, seconds), commanded
        return pose, velocity

    def _ends(self) -> list[float]:
        return [begin for begin, _ in self._commands][1:]


def _error(commanded: Velocity, measured: Velocity) -> float:
    """Return the squared error of a velocity [(m/s)²]."""
    linear, angular = measured.linear - commanded.linear, (measured.angular - commanded.angular) / TURN_SCALE
    return linear * linear + angular * angular
